//! `bench`: speed, measured beside what it is to be compared with.

mod page;
mod scan;
mod step;
mod sweep;

use std::time::{Duration, Instant};

use rusty_contract::config::check_seconds;
use rusty_contract::{Exit, FieldError, MAX_PARTICIPANTS, RunName, errln, outln};
use rusty_link::{Domain, floor, raw};

use super::Verbed;
use crate::cli::{
    BenchCommonArgs, BenchLogArgs, BenchNoiseArgs, BenchPeerArgs, BenchVerb, IdleArgs, LatencyArgs,
    StartArgs,
};
use crate::error::VerbError;
use rusty_bench::latency::{self, Plan};
use rusty_bench::noise::NoiseMeter;
use rusty_bench::report::{Printing, Report};
use rusty_bench::stage::Bare;
use rusty_bench::{idle, log, start};
use rusty_engine::run::Stop;

/// Runs one bench: exit 0 if its results can be believed, 1 if not.
///
/// # Errors
/// As the bench.
pub fn bench(what: &BenchVerb) -> Verbed {
    match what {
        BenchVerb::Latency(args) => latency(args),
        BenchVerb::Idle(args) => idle(args),
        BenchVerb::Start(args) => start(args),
        BenchVerb::Log(args) => log(args),
        BenchVerb::Noise(args) => noise(args),
        BenchVerb::Scan(args) => scan::scan(args),
        BenchVerb::Step(args) => step::step(args),
        BenchVerb::Sweep(args) => sweep::sweep(args),
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
    check_seconds("--seconds", args.seconds)?;
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

/// A log beside a plain file.
fn log(args: &BenchLogArgs) -> Verbed {
    if args.repeat == 0 {
        let remedy = "give 1 or more";
        return Err(FieldError::new("--repeat", 0, "measures nothing", remedy).into());
    }
    let plan = log::Plan {
        folder: args.folder.clone(),
        ticks: args.ticks,
        beams: args.beams.clone(),
        sync: args.sync,
        repeat: args.repeat,
        quiet: args.common.quiet,
    };
    let mut meter = NoiseMeter::begin();
    let results = plan.measure(&mut meter)?;
    let report = Report::new("log", meter.finish(), results);
    Ok(report.finish(args.common.printing(), log::print))
}

/// Ticks, raw rounds and the floor, in turns.
fn latency(args: &LatencyArgs) -> Verbed {
    check(args)?;
    let (run, stop) = prepare()?;
    let plan = Plan {
        clients: args.clients.clone(),
        beams: args.beams.clone(),
        scan_every: args.scan_every.clone(),
        mix: args.mix,
        beside: args.beside.split_whitespace().map(str::to_owned).collect(),
        ticks: args.ticks,
        repeat: args.repeat,
        wait: args.wait,
        pin: args.pin.clone(),
        quiet: args.common.quiet,
    };
    let mut meter = NoiseMeter::begin();
    let Some(results) = plan.measure(&run, &stop, &mut meter)? else {
        return Ok(stopped());
    };
    let report = Report::new("latency", meter.finish(), results);
    Ok(report.finish(args.common.printing(), latency::print))
}

fn check(args: &LatencyArgs) -> Result<(), FieldError> {
    let bad = |field: &str, value: &dyn std::fmt::Display, problem: &str, remedy: &str| {
        Err(FieldError::new(field, value, problem, remedy))
    };
    if let Some(n) = args.clients.iter().find(|n| !(1..=MAX_PARTICIPANTS).contains(*n)) {
        return bad("--clients", n, "a run has 1 to 16 participants", "give such numbers");
    }
    if args.ticks < 100 {
        return bad("--ticks", &args.ticks, "too few for any quantile", "give 100 or more");
    }
    if args.repeat == 0 {
        return bad("--repeat", &args.repeat, "measures nothing", "give 1 or more");
    }
    Ok(())
}

/// What waiting costs.
fn idle(args: &IdleArgs) -> Verbed {
    check_seconds("--seconds", args.seconds)?;
    let (run, stop) = prepare()?;
    let meter = NoiseMeter::begin();
    let Some(results) = idle::measure(&run, args.wait, args.seconds, &stop)? else {
        return Ok(stopped());
    };
    let report = Report::new("idle", meter.finish(), results);
    Ok(report.finish(args.common.printing(), idle::print))
}

/// From a start to the first frame.
fn start(args: &StartArgs) -> Verbed {
    if args.repeat == 0 {
        let remedy = "give 1 or more";
        return Err(FieldError::new("--repeat", 0, "measures nothing", remedy).into());
    }
    let (run, stop) = prepare()?;
    let mut meter = NoiseMeter::begin();
    let Some(results) = start::measure(&run, args.repeat, &stop, &mut meter)? else {
        return Ok(stopped());
    };
    let report = Report::new("start", meter.finish(), results);
    Ok(report.finish(args.common.printing(), start::print))
}

/// A name that no other bench has, and an ear for Ctrl-C.
fn prepare() -> Result<(RunName, Stop), VerbError> {
    let random = getrandom::u32().map_err(VerbError::Random)?;
    let run = RunName::new(&format!("bench-{random:08x}"))?;
    let stop = Stop::listen(&run).map_err(VerbError::Signals)?;
    // What killed runs left goes first.
    let _ = Domain::sweep_dead();
    Ok((run, stop))
}

fn stopped() -> Exit {
    errln!("stopped; nothing of it is kept");
    Exit::Lost
}

/// A client without a protocol.
///
/// # Errors
/// [`VerbError`] if there is nothing to take part in.
pub fn bench_peer(args: &BenchPeerArgs) -> Verbed {
    if args.what == Bare::Raw.word() {
        raw::serve_raw(&args.run, args.wait)?;
    } else {
        floor::serve_floor(&args.run, args.client, args.wait)?;
    }
    Ok(Exit::Done)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Args as _, Command, FromArgMatches as _};

    #[test]
    fn without_arguments_a_log_has_the_beams_of_the_page() {
        let matches = BenchLogArgs::augment_args(Command::new("log")).get_matches_from(["log"]);
        assert_eq!(BenchLogArgs::from_arg_matches(&matches).unwrap().beams, log::BEAMS);
    }
}
