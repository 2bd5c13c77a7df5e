//! Recordings of real robots, as run logs.
//!
//! [`import_carmen`] reads a log of the Carnegie Mellon Robot Navigation
//! Toolkit (CARMEN), plain or gzip, and writes a run log that every program
//! here can read: each odometry reading becomes a tick with encoder counts,
//! each laser scan a tick with ranges and, as truth, its corrected pose.
//!
//! In reading order: `lines` (gzip, long lines), `carmen` (one line), `preview`
//! (echoes, flat stamps), `detached` (echoes whose scan was deleted), `recording` (readings, scans, and echoes that are
//! neither), `wheels` (counts from poses), `ranges` (codes for no return),
//! `survey` (what must be known before the first tick), `judge` (findings),
//! `plan` (header and remarks), `convert` (writing), [`report`], [`error`]; then [`ros`]
//! (MCAP and rosbag2 by the same way).
//!
//! Source of the format: the CARMEN logger, see `carmen`. Departures:
//!
//! * a recording has no commands and no encoder counts. The commands of all
//!   frames are zero; the counts belong to virtual wheels, see `wheels`;
//! * nothing is resampled: ticks are in file order, at the file's own times,
//!   which are neither rebased nor sorted. Only where the stamps stand still are
//!   ticks numbered at a nominal rate;
//! * truth is what a SLAM back end computed, at scans; elsewhere there is none.

pub mod error;
pub mod report;
pub mod ros;

mod carmen;
mod convert;
mod detached;
mod findings;
mod judge;
mod lines;
mod plan;
mod preview;
mod ranges;
mod recording;
mod survey;
mod wheels;

#[cfg(test)]
mod tests;

pub use convert::{ImportOptions, import_carmen};
pub use error::ImportError;
pub use report::ImportReport;

/// How many times the recording is read.
const PASSES: u64 = 4;
/// Lines between two calls of the caller's function.
const PROGRESS_LINES: u64 = 1000;

/// Tells the caller how far the import is, as a number of lines: a quarter of a
/// line for each time it was read, so that the number ends where the file does.
/// On the way it is told in whole thousands.
struct Progress<'a> {
    tell: &'a mut dyn FnMut(u64),
    /// Lines of the passes before.
    before: u64,
    told: u64,
}

impl<'a> Progress<'a> {
    fn new(tell: &'a mut dyn FnMut(u64)) -> Self {
        Self { tell, before: 0, told: 0 }
    }

    /// Line `line` of this pass was read.
    fn at(&mut self, line: u64) {
        let lines = (self.before + line) / PASSES / PROGRESS_LINES * PROGRESS_LINES;
        if lines > self.told {
            self.told = lines;
            (self.tell)(lines);
        }
    }

    /// This pass is over, after `lines` lines.
    fn pass(&mut self, lines: u64) {
        self.before += lines;
        self.told = self.before / PASSES;
        (self.tell)(self.told);
    }
}

/// Ticks per second of a recording whose stamps stand still.
pub(super) const NOMINAL_RATE_HZ: f64 = 10.0;
