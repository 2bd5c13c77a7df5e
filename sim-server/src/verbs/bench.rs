//! `bench`: speed, measured beside what it is to be compared with.

mod page;
mod scan;
mod step;

use std::time::{Duration, Instant};

use super::Verbed;
use crate::bench::noise::NoiseMeter;
use crate::bench::report::{Printing, Report};
use crate::cli::{BenchCommonArgs, BenchNoiseArgs, BenchVerb};
use crate::output::outln;

/// Runs one bench: exit 0 if its results can be believed, 1 if not.
///
/// # Errors
/// As the bench.
pub fn bench(what: &BenchVerb) -> Verbed {
    match what {
        BenchVerb::Noise(args) => noise(args),
        BenchVerb::Scan(args) => scan::scan(args),
        BenchVerb::Step(args) => step::step(args),
        BenchVerb::Page(args) => page::page(args),
    }
}

impl BenchCommonArgs {
    /// How the report is printed.
    fn printing(self) -> Printing {
        Printing { json: self.json, accept_noise: self.accept_noise }
    }
}

/// Looks at the machine for a while.
fn noise(args: &BenchNoiseArgs) -> Verbed {
    rusty_contract::config::check_seconds("--seconds", args.seconds)?;
    let until = Instant::now() + Duration::from_secs_f64(args.seconds);
    let mut meter = NoiseMeter::begin();
    while Instant::now() < until {
        meter.look();
    }
    let noise = meter.finish();
    let results = noise.disturbances;
    let report = Report::new("noise", noise, results);
    Ok(report.finish(args.common.printing(), |found| {
        let work = found.work;
        outln!("a fixed piece of work, {} times", work.count);
        outln!(
            "  p50 {} ns, p90 {} ns, p99 {} ns, max {} ns",
            work.p50_ns,
            work.p90_ns,
            work.p99_ns,
            work.max_ns
        );
        outln!("  p90 {:.1} % above the shortest", 100.0 * found.work_stretch);
        outln!("  put off its core {:.1} times a second", found.put_off_per_s);
        let cores =
            |cores: Option<f64>| cores.map_or("unknown".to_owned(), |c| format!("{c:.2} cores"));
        outln!("other processes   {}", cores(found.others_cores));
        outln!("the hypervisor    {}", cores(found.stolen_cores));
    }))
}
