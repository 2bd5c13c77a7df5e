//! `Answering`: a filter on logs that were handed out, and its trajectories.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rusty_contract::scenario::Access;
use rusty_contract::{Frame, LogHeader, Reply, Role, Sandbox, replace, tum};
use rusty_engine::source::{FrameSource, SourceError};
use rusty_geometry::{SE2, Twist};
use serde::Serialize;

use super::entry::{Entry, started};
use super::error::BenchmarkError;
use super::play::{play, side_by_side};
use super::recordings::{OpenLog, check_names, name, opened};

/// Logs that are replayed to a filter.
pub struct Answering<'a> {
    /// The filter.
    pub entry: &'a Entry,
    /// Whether the kernel confines it.
    pub confined: bool,
    /// The logs.
    pub logs: &'a [PathBuf],
    /// Folder of the trajectories.
    pub out: &'a Path,
    /// Opens a log.
    pub open: OpenLog,
    /// Runs at a time.
    pub jobs: usize,
}

/// The result of a log.
#[derive(Clone, Debug, Serialize)]
pub struct Answered {
    /// Name of the run.
    pub run: String,
    /// The trajectory; none if the filter was lost.
    pub trajectory: Option<PathBuf>,
    /// The reason for no trajectory.
    pub failure: Option<String>,
}

impl Answering<'_> {
    /// Writes a trajectory in TUM format for each log, `NAME.tum` for `NAME.log`. Returns
    /// the result of each; of fewer if `stop` was raised. `progress` is told the number of
    /// each before it begins.
    ///
    /// # Errors
    /// [`BenchmarkError`] if two logs have the same name, a log cannot be replayed or a file
    /// cannot be written.
    pub fn write(
        &self,
        stop: &Arc<AtomicBool>,
        progress: impl Fn(usize) + Sync,
    ) -> Result<Vec<Answered>, BenchmarkError> {
        check_names("LOG", self.logs)?;
        side_by_side(self.logs.len(), self.jobs, stop, |number| {
            progress(number);
            self.one(&self.logs[number], stop)
        })
    }

    fn one(&self, log: &Path, stop: &Arc<AtomicBool>) -> Result<Option<Answered>, BenchmarkError> {
        let run = name(log);
        let entry = self.entry.of_run(&run);
        let sandbox = if self.confined { Sandbox::Required } else { Sandbox::None };
        // A blind log tells what may be known.
        let own = entry.participant(Access::Given, Access::Given, sandbox);
        let roster = [own, started("score", Role::Scorer, &["score".to_owned()])];
        let source = opened(log, &roster, self.open)?;
        let mut source =
            AnswersSource { source, name: entry.name, time_s: 0.0, lines: String::new() };
        let report = play(&roster, &mut source, stop)?;
        if report.ended == "interrupted" {
            return Ok(None);
        }
        if let Some(failure) = report.lost() {
            return Ok(Some(Answered { run, trajectory: None, failure: Some(failure) }));
        }
        let path = self.out.join(format!("{run}.tum"));
        replace(&path, source.lines.as_bytes()).map_err(BenchmarkError::io(&path))?;
        Ok(Some(Answered { run, trajectory: Some(path), failure: None }))
    }
}

/// A log, and the poses of one who answers.
struct AnswersSource {
    source: Box<dyn FrameSource>,
    name: String,
    time_s: f64,
    lines: String,
}

impl FrameSource for AnswersSource {
    fn header(&self) -> &LogHeader {
        self.source.header()
    }

    fn tick_count(&self) -> u64 {
        self.source.tick_count()
    }

    fn make(
        &mut self,
        driver: Option<Twist>,
        frame: &mut Frame,
    ) -> Result<Option<SE2>, SourceError> {
        let truth = self.source.make(driver, frame)?;
        self.time_s = frame.time_s();
        Ok(truth)
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        self.source.again()
    }

    fn closed(&mut self, replies: &mut dyn Iterator<Item = (&str, Reply)>) {
        for (_, reply) in replies.filter(|(name, _)| *name == self.name) {
            if let Some(estimate) = reply.estimate() {
                self.lines += &tum::line(self.time_s, &estimate.pose_in_world);
                self.lines.push('\n');
            }
        }
    }
}
