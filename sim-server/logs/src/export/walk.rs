//! The ticks of a log with the answers in effect, to wherever it ends.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use rusty_contract::log::{Ending, LogReader, Read, TickRecord, Trailer};
use rusty_contract::{Effects, Estimate, LogHeader};
use rusty_geometry::{SE2, Twist};
use serde::Serialize;

use super::error::ExportError;

/// A walk along a log. Which answers are in effect is the rule of the scorer:
/// one whose compute time is modelled counts when that is over.
pub struct Walk<'s> {
    pub log: String,
    reader: LogReader,
    pub header: LogHeader,
    effects: Effects,
    stop: &'s AtomicBool,
    /// How far the walk is, and where it ended.
    pub walked: Walked,
    /// The last line of a complete log, once the walk is there.
    pub trailer: Option<Trailer>,
}

/// Where a walk ended.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Walked {
    /// Complete ticks.
    pub ticks: u64,
    /// Records whose checksum fails: their values are suspect.
    pub damaged_records: u64,
    /// Where the log was cut, if it was.
    pub cut: Option<String>,
}

/// Order of the stamps of the ticks that are written.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StampOrder {
    #[serde(skip)]
    last_s: Option<f64>,
    /// Ticks with the stamp of the tick before: evo confuses their poses.
    pub stamps_repeated: u64,
    /// Ticks with an earlier stamp than the tick before.
    pub stamps_backwards: u64,
}

impl StampOrder {
    /// Takes the stamp of the next tick, s.
    pub fn see(&mut self, stamp_s: f64) {
        if let Some(last_s) = self.last_s.replace(stamp_s) {
            self.stamps_repeated += u64::from(stamp_s == last_s);
            self.stamps_backwards += u64::from(stamp_s < last_s);
        }
    }
}

impl Walked {
    /// Nothing of the log is missing or suspect.
    pub fn is_whole(&self) -> bool {
        self.damaged_records == 0 && self.cut.is_none()
    }
}

impl<'s> Walk<'s> {
    /// At the start of a log. `stop` ends the walk with an error.
    pub fn open(log: &Path, stop: &'s AtomicBool) -> Result<Self, ExportError> {
        let reader = LogReader::open(log)?;
        let header = reader.header().clone();
        let effects = Effects::of(&header);
        let walked = Walked::default();
        let (log, trailer) = (log.display().to_string(), None);
        Ok(Self { log, reader, header, effects, stop, walked, trailer })
    }

    /// Names of those that answer, in roster order.
    pub fn names(&self) -> Vec<String> {
        self.header.answering().map(|p| p.name.clone()).collect()
    }

    /// The next tick; `None` after the last complete one.
    pub fn tick(&mut self) -> Result<Option<TickRecord>, ExportError> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(ExportError::Interrupted(self.log.clone()));
        }
        match self.reader.read()? {
            Read::Tick(entry) => {
                let record = entry.record;
                let has_scan = record.ranges_m.is_some();
                self.effects.close(record.tick, has_scan, record.replies.iter().copied());
                self.walked.ticks += 1;
                Ok(Some(record))
            }
            Read::End(ending) => {
                self.walked.damaged_records = self.reader.damaged();
                match ending {
                    Ending::Complete(trailer) => self.trailer = Some(trailer),
                    Ending::Cut { ticks, at_byte, problem } => {
                        let how = format!("cut after {ticks} complete ticks, at byte {at_byte}");
                        self.walked.cut = Some(format!("{how}: {problem}"));
                    }
                }
                Ok(None)
            }
        }
    }

    /// The command in effect after the tick that came last, for the next one.
    pub fn command(&self) -> Twist {
        self.effects.command().unwrap_or_default()
    }

    /// The estimates in effect after the tick that came last, in roster order;
    /// poses that are no numbers are none.
    pub fn estimates(&self) -> impl Iterator<Item = Option<Estimate>> + '_ {
        let estimate = |e: &Estimate| e.pose_in_world.is_finite();
        self.effects.replies().map(move |reply| reply.estimate().copied().filter(estimate))
    }
}

/// The true pose of a tick, where it is known and made of numbers.
pub fn truth(record: &TickRecord) -> Option<SE2> {
    record.pose_in_world().filter(SE2::is_finite)
}
