//! `bench sweep`.

use std::time::Duration;

use rusty_contract::config::check_seconds;

use super::super::Verbed;
use crate::cli::BenchSweepArgs;
use rusty_bench::machine::cores;
use rusty_bench::noise::NoiseMeter;
use rusty_bench::report::Report;
use rusty_bench::sweep::{results::SweepResults, run};

/// Measures sweeps without clients.
///
/// # Errors
/// A time that is none.
pub fn sweep(args: &BenchSweepArgs) -> Verbed {
    check_seconds("--seconds", args.seconds)?;
    let jobs = args.jobs.map_or_else(cores, usize::from);
    let meter = NoiseMeter::begin();
    let results = run(Duration::from_secs_f64(args.seconds), jobs)?;
    let report = Report::new("sweep", meter.finish(), results);
    Ok(report.finish(args.common.printing(), SweepResults::print))
}
