//! A few runs of a sweep, to measure how long one takes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use super::error::SweepError;
use super::job::SweepJob;
use super::record::Record;
use super::workers::Listener;

/// The most runs of a pilot.
const MOST_RUNS: u64 = 200;
/// The longest a pilot takes, if one run has ended by then.
const LIMIT: Duration = Duration::from_secs(10);

/// Makes up to 200 runs of `job`, evenly spaced, within about 10 s. Returns the mean
/// time of a run on `job.jobs` cores, s; `None` if `stop` is raised.
///
/// # Errors
/// [`SweepError`] of the runs.
pub fn run_time_s(job: &SweepJob, stop: &AtomicBool) -> Result<Option<f64>, SweepError> {
    let count = job.plan.count();
    let runs = count.min(MOST_RUNS);
    let todo: Vec<u64> = (0..runs).map(|k| job.plan.runs.start + count * k / runs).collect();
    let enough = Arc::<AtomicBool>::default();
    let (began, elapsed) = (Instant::now(), Duration::ZERO);
    let mut pilot = Pilot { stop, enough: &enough, began, elapsed, runs: 0 };
    job.make(&todo, &enough, &AtomicU64::new(0), &mut pilot)?;
    let stopped = stop.load(Ordering::Relaxed) || pilot.runs == 0;
    Ok((!stopped).then(|| pilot.elapsed.as_secs_f64() / pilot.runs as f64))
}

struct Pilot<'s> {
    stop: &'s AtomicBool,
    /// Raised after the limit.
    enough: &'s AtomicBool,
    began: Instant,
    /// Time up to the last run that ended.
    elapsed: Duration,
    runs: u64,
}

impl Listener for Pilot<'_> {
    fn done(&mut self, _: Record, _: &[u8]) -> Result<(), SweepError> {
        self.elapsed = self.began.elapsed();
        self.runs += 1;
        Ok(())
    }

    fn pause(&mut self) -> Result<(), SweepError> {
        let is_over = self.runs > 0 && self.began.elapsed() > LIMIT;
        if is_over || self.stop.load(Ordering::Relaxed) {
            self.enough.store(true, Ordering::Relaxed);
        }
        Ok(())
    }
}
