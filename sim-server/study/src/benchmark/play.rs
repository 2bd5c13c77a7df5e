//! `play`: a single run in new processes, and several of them at a time.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rusty_contract::{Participant, RunName, Scenario};
use rusty_engine::confine;
use rusty_engine::run::{RunBuilder, RunError, Stop};
use rusty_engine::source::FrameSource;

use super::error::BenchmarkError;
use crate::sweep::SweepError;
use crate::sweep::crews::report;
use crate::sweep::run_report::RunReport;

/// Numbers of the runs of this process, for their names.
static RUNS: AtomicUsize = AtomicUsize::new(0);

/// Makes the run of `source` with these participants, in new processes. One that is lost is
/// in the report.
///
/// # Errors
/// [`BenchmarkError`] if it cannot be made.
pub(super) fn play(
    roster: &[Participant],
    source: &mut dyn FrameSource,
    stop: &Arc<AtomicBool>,
) -> Result<RunReport, BenchmarkError> {
    let failed = |e: RunError| BenchmarkError::Sweep(e.into());
    // Participants cannot read the truth from this process.
    confine::close_memory().map_err(BenchmarkError::io(Path::new("this process's memory")))?;
    let number = RUNS.fetch_add(1, Ordering::Relaxed);
    let name = RunName::new(&format!("benchmark-{}-{number}", std::process::id()))
        .map_err(SweepError::from)?;
    let Scenario { join_timeout_s, answer_timeout_s, .. } = Scenario::default();
    let options = RunBuilder {
        join_timeout_s,
        answer_timeout_s,
        report: false,
        stop: Some(Stop::of(Arc::clone(stop))),
        ..RunBuilder::new(name, Default::default())
    };
    let prepared = options.prepare(roster).map_err(failed)?;
    let out = prepared.domain().folder().join("out");
    let crew = prepared.crew(roster, &out).map_err(failed)?;
    let (outcome, crew) = crew.run(source, &out).map_err(failed)?;
    let report = report(&outcome, roster, &out);
    let _ = crew.finish();
    Ok(report)
}

/// Does `make` for the numbers below `count`, `jobs` at a time, until one fails or `stop` is
/// raised. Returns the results in order.
///
/// # Errors
/// The error of the smallest number.
pub(super) fn side_by_side<T: Send>(
    count: usize,
    jobs: usize,
    stop: &AtomicBool,
    make: impl Fn(usize) -> Result<Option<T>, BenchmarkError> + Sync,
) -> Result<Vec<T>, BenchmarkError> {
    let (next, has_failed) = (AtomicUsize::new(0), AtomicBool::new(false));
    let work = || {
        let mut made = Vec::new();
        while !stop.load(Ordering::Relaxed) && !has_failed.load(Ordering::Relaxed) {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= count {
                break;
            }
            let one = make(number);
            has_failed.fetch_or(one.is_err(), Ordering::Relaxed);
            made.push((number, one));
        }
        made
    };
    let mut all = std::thread::scope(|scope| {
        let others: Vec<_> = (1..jobs.min(count)).map(|_| scope.spawn(work)).collect();
        let mut all = work();
        for other in others {
            all.extend(other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        all
    });
    all.sort_by_key(|(number, _)| *number);
    all.into_iter().filter_map(|(_, one)| one.transpose()).collect()
}
