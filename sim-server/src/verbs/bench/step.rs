//! `bench step`.

use std::time::Duration;

use rusty_contract::config::check_seconds;

use super::super::Verbed;
use crate::cli::BenchStepArgs;
use rusty_bench::noise::NoiseMeter;
use rusty_bench::report::Report;
use rusty_bench::step::{results::StepResults, run};

/// Measures the parts of a tick.
///
/// # Errors
/// A time that is none.
pub fn step(args: &BenchStepArgs) -> Verbed {
    check_seconds("--seconds", args.seconds)?;
    let meter = NoiseMeter::begin();
    let results = run(Duration::from_secs_f64(args.seconds))?;
    let report = Report::new("step", meter.finish(), results);
    Ok(report.finish(args.common.printing(), StepResults::print))
}
