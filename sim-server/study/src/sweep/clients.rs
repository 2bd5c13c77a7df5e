//! Runs with client processes: whole lockstep runs, side by side. Their processes stay for
//! many runs, unless the folders of the runs are kept.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64};

use super::crews::Crews;
use super::error::SweepError;
use super::launches::Launches;
use super::plan::Plan;
use super::record::Record;
use super::workers::Maker;

/// One worker: one run after the other.
pub enum Clients<'p> {
    /// In the processes of a crew.
    Crews(Box<Crews<'p>>),
    /// In new processes for each run, whose folder is kept.
    Launches(Launches<'p>),
}

impl<'p> Clients<'p> {
    /// A worker for the runs of `plan`. With `keep`, there is a folder for each in `folder`
    /// and stays; with `force`, one of an earlier sweep is replaced.
    #[must_use]
    pub fn new(
        plan: &'p Plan,
        stop: &'p Arc<AtomicBool>,
        ticks_done: &'p AtomicU64,
        folder: &'p Path,
        (keep, force): (bool, bool),
    ) -> Self {
        match keep {
            true => Self::Launches(Launches::new(plan, stop, ticks_done, folder, force)),
            false => Self::Crews(Box::new(Crews::new(plan, stop, ticks_done, folder))),
        }
    }
}

impl Maker for Clients<'_> {
    fn make(&mut self, run: u64) -> Result<Option<Record>, SweepError> {
        match self {
            Self::Crews(crews) => crews.make(run),
            Self::Launches(launches) => launches.make(run),
        }
    }

    fn finish(&mut self) -> Result<(), SweepError> {
        match self {
            Self::Crews(crews) => crews.finish(),
            Self::Launches(launches) => launches.finish(),
        }
    }
}
