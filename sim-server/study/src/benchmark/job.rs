//! `BenchmarkJob`: makes the runs of a benchmark.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rusty_contract::{Sandbox, errln};
use rusty_engine::run::Progress;

use super::block::{Block, blocks};
use super::entry::Entry;
use super::error::BenchmarkError;
use super::recordings::{OpenLog, Recordings};
use super::run::BenchmarkRun;
use super::selection::Selection;
use super::suite::Suite;
use super::track::map_word;
use crate::sweep::{Plan, SweepJob};

/// What there is to do, and how.
pub struct BenchmarkJob<'s> {
    /// The suite.
    pub suite: &'s Suite,
    /// The part of it.
    pub selection: &'s Selection,
    /// Those whose runs are made.
    pub entries: &'s [Entry],
    /// Whether entries are confined by the kernel.
    pub confined: bool,
    /// Logs of the recordings in the selection.
    pub recordings: &'s Recordings,
    /// Opens one of them.
    pub open: OpenLog,
    /// Runs at a time.
    pub jobs: usize,
    /// Whether no progress is shown.
    pub quiet: bool,
}

impl BenchmarkJob<'_> {
    /// Makes all runs; `None` if `stop` was raised before the last.
    ///
    /// # Errors
    /// [`BenchmarkError`] if a run cannot be made. A participant that is lost is not an
    /// error: its run has a failure.
    pub fn make(
        &self,
        stop: &Arc<AtomicBool>,
    ) -> Result<Option<Vec<BenchmarkRun>>, BenchmarkError> {
        let sandbox = if self.confined { Sandbox::Required } else { Sandbox::None };
        let blocks = blocks(self.suite, self.selection, self.entries);
        // Whatever is wrong with one of them shows before the first run.
        self.recordings.check_names(self.entries)?;
        let plan = |block: &Block<'_>| {
            let is_recorded = block.scenario.is_recorded();
            (!is_recorded).then(|| block.plans(self.selection, sandbox)).transpose()
        };
        let plans: Vec<Option<Vec<Plan>>> = blocks.iter().map(plan).collect::<Result<_, _>>()?;
        let mut runs = Vec::new();
        let count = blocks.len();
        for (place, (block, plans)) in blocks.iter().zip(plans).enumerate() {
            if !self.quiet {
                let (scenario, entry) = (&block.scenario.name, &block.entry.name);
                errln!(
                    "{} of {count}: {scenario}, map {}, {entry}",
                    place + 1,
                    map_word(block.map)
                );
            }
            match plans {
                Some(plans) => {
                    for plan in plans {
                        runs.extend(self.planned(block, plan, stop)?);
                    }
                }
                None => {
                    let how = (sandbox, self.jobs);
                    runs.extend(self.recordings.runs(block, how, self.open, stop)?);
                }
            }
            if stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
        }
        Ok(Some(runs))
    }

    fn planned(
        &self,
        block: &Block<'_>,
        plan: Plan,
        stop: &Arc<AtomicBool>,
    ) -> Result<Vec<BenchmarkRun>, BenchmarkError> {
        let ticks = plan.runs.clone().map(|run| plan.ticks(run)).sum();
        let job = SweepJob {
            plan,
            writer: String::new(),
            jobs: self.jobs,
            table: None,
            resume: false,
            force: false,
            runs_dir: None,
        };
        let made = job.records(None, Vec::new(), stop, Progress::new(ticks, self.quiet))?;
        let mut runs = Vec::new();
        for record in &made.records {
            let planned = job.plan.ticks(record.run);
            // The scenario's driver has a row, too.
            for row in record.rows.iter().filter(|row| row.estimator == block.entry.name) {
                let place = (block.scenario, block.map);
                runs.push(BenchmarkRun::of(row, record.lost.as_deref(), planned, place));
            }
        }
        Ok(runs)
    }
}
