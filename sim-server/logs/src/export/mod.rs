//! A log for other programs: trajectories for evo, a table for everything else.
//!
//! In reading order: `walk` (the ticks of a log with the answers in effect), `sheet`
//! (a file that is there when it is complete, or not at all), [`tum`] (trajectories
//! in the format of the TUM RGB-D benchmark), [`csv`] and [`parquet`] (all ticks as one
//! table), [`mcap`] and [`rosbag`] (all ticks as messages of ROS 2) and [`scenario`] (the run
//! again, without its driver).

pub mod csv;
mod error;
pub mod mcap;
pub mod parquet;
pub mod rosbag;
pub mod scenario;
mod sheet;
pub mod tum;
mod walk;

pub use error::ExportError;
pub use walk::{StampOrder, Walked};

use rusty_contract::log::TickRecord;
use serde::Serialize;

use walk::Walk;

/// What an export came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Exported {
    /// The log.
    pub log: String,
    /// Where its ticks ended.
    #[serde(flatten)]
    pub walked: Walked,
    /// Ticks with a known true pose.
    pub ticks_with_truth: u64,
    /// Order of the stamps.
    #[serde(flatten)]
    pub stamps: StampOrder,
    /// The files written.
    pub files: Vec<Written>,
    /// Answering participants of which nothing is written: they never said a
    /// pose that could be.
    pub without: Vec<String>,
}

/// A file that was written.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Written {
    /// Whose poses they are; `None` for the truth, or where all are together.
    pub estimator: Option<String>,
    /// The file.
    pub path: String,
    /// Lines of poses, or of ticks.
    pub lines: u64,
}

/// What the rows of a table came to, tick by tick.
struct Rows {
    ticks_with_truth: u64,
    stamps: StampOrder,
    /// Which participants had a pose.
    said: Vec<bool>,
}

impl Rows {
    fn of(walk: &Walk<'_>) -> Self {
        let said = vec![false; walk.header.answering().count()];
        Self { ticks_with_truth: 0, stamps: StampOrder::default(), said }
    }

    /// Takes the tick that was walked last.
    fn see(&mut self, record: &TickRecord, walk: &Walk<'_>) {
        self.ticks_with_truth += u64::from(walk::truth(record).is_some());
        self.stamps.see(record.time_s(walk.header.config.dt_s));
        for (said, estimate) in self.said.iter_mut().zip(walk.estimates()) {
            *said |= estimate.is_some();
        }
    }

    fn exported(self, walk: Walk<'_>, path: String) -> Exported {
        let lines = walk.walked.ticks;
        let silent = walk.names().into_iter().zip(self.said).filter(|(_, said)| !said);
        Exported {
            ticks_with_truth: self.ticks_with_truth,
            stamps: self.stamps,
            files: vec![Written { estimator: None, lines, path }],
            without: silent.map(|(name, _)| name).collect(),
            log: walk.log,
            walked: walk.walked,
        }
    }
}
