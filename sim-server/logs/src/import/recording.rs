//! What the lines mean together: readings, scans, and echoes of scans.
//!
//! Where a file has echoes (see `preview`), the first `ODOM` line after a `FLASER`
//! that repeats its first pose digit for digit is no reading of the odometry but
//! an *anchor*: the `ODOM` lines that follow go on *from that pose*, and the
//! odometry is the chain of increments, from line to line and across a scan from
//! the anchor to the next line. Taken as one path the `ODOM` lines would jump
//! sideways at every scan (up to 17 cm in the log of the Intel Research Lab)
//! and would never drift. The increments are the robot's own, without the noise
//! of a particle: in the Intel log 99.6 % of the turns are whole multiples of
//! one heading step, 6.1455 mrad.

use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;

use rusty_geometry::SE2;

use super::carmen::{MEND, Message, Stamps, Triple, is_time, parse};
use super::error::{ImportError, excerpt};
use super::lines::Lines;

/// How many unknown types of message are told apart.
const MAX_TYPES: usize = 64;

/// One thing that happened, in file order. Poses are the file's.
#[derive(Debug)]
pub(super) enum Event<'a> {
    /// A reading of the odometry.
    Reading { pose: SE2, stamp_s: f64, line: u64 },
    /// The odometry goes on from here; time does not.
    Anchor { pose: SE2, line: u64 },
    /// A scan.
    Scan {
        /// The first pose of the line: corrected, if anything is. `None`: not known.
        pose: Option<SE2>,
        /// The odometry's own pose, where the line has one that differs.
        odometry: Option<SE2>,
        stamp_s: f64,
        /// As they are in the file, m.
        ranges_m: &'a [f64],
        line: u64,
    },
}

impl Event<'_> {
    /// The line it is in, from 1.
    pub(super) fn line(&self) -> u64 {
        match self {
            Self::Reading { line, .. } | Self::Anchor { line, .. } | Self::Scan { line, .. } => {
                *line
            }
        }
    }
}

/// A recording, read event by event.
pub(super) trait Events {
    /// The next event, or `None` at the end of the recording.
    fn next_event(&mut self) -> Result<Option<Event<'_>>, ImportError>;

    /// What was read so far.
    fn facts(&self) -> Facts<'_>;
}

/// What was read of a recording so far.
#[derive(Debug)]
pub(super) struct Facts<'a> {
    /// The file, for messages.
    pub(super) path: &'a str,
    /// Number of the line just read, from 1; of a recording of ROS, of the message.
    pub(super) line: u64,
    /// Readings and scans whose two stamps differ.
    pub(super) two_times: u64,
    /// Types of messages that are not read, with their numbers.
    pub(super) skipped: &'a BTreeMap<String, u64>,
}

/// A CARMEN log, read event by event.
pub(super) struct Recording {
    lines: Lines,
    ranges_m: Vec<f64>,
    /// First pose of the scan before, until an `ODOM` line follows.
    fresh_scan: Option<Triple>,
    has_echoes: bool,
    /// Further anchors: their lines, in order.
    detached: Rc<[u64]>,
    skipped: BTreeMap<String, u64>,
    two_times: u64,
}

impl Recording {
    /// Opens a log, plain or gzip; `has_echoes` and `detached` are what its preview decided.
    pub(super) fn open(
        path: &Path,
        has_echoes: bool,
        detached: Rc<[u64]>,
    ) -> Result<Self, ImportError> {
        Ok(Self {
            lines: Lines::open(path)?,
            ranges_m: Vec::new(),
            fresh_scan: None,
            has_echoes,
            detached,
            skipped: BTreeMap::new(),
            two_times: 0,
        })
    }

    fn odom(&mut self, pose: Triple, stamps: Stamps) -> Result<Event<'static>, ImportError> {
        let (stamp_s, line) = (stamps.measured_s, self.lines.line);
        let is_echo = self.fresh_scan.take() == Some(pose) && self.has_echoes;
        if is_echo || self.detached.binary_search(&line).is_ok() {
            return Ok(Event::Anchor { pose: se2(pose), line });
        }
        if !is_time(stamp_s) {
            let problem = format!("ODOM field 7 (stamp) = \"{stamp_s}\": is no time; {MEND}");
            return Err(ImportError::line(&self.lines.path, line, problem));
        }
        self.two_times += u64::from(stamp_s != stamps.logged_s);
        Ok(Event::Reading { pose: se2(pose), stamp_s, line })
    }
}

impl Events for Recording {
    fn next_event(&mut self) -> Result<Option<Event<'_>>, ImportError> {
        while self.lines.advance()? {
            let (path, line) = (&self.lines.path, self.lines.line);
            match parse(path, line, &self.lines.text, &mut self.ranges_m)? {
                Message::Blank | Message::Param { .. } => {}
                Message::Other(name) => count(&mut self.skipped, name),
                Message::Odom { pose, stamps } => return self.odom(pose, stamps).map(Some),
                Message::Flaser { pose, odometry, stamps } => {
                    self.two_times += u64::from(stamps.measured_s != stamps.logged_s);
                    self.fresh_scan = Some(pose);
                    return Ok(Some(Event::Scan {
                        pose: Some(se2(pose)),
                        odometry: (odometry != pose).then(|| se2(odometry)),
                        stamp_s: stamps.measured_s,
                        ranges_m: &self.ranges_m,
                        line,
                    }));
                }
            }
        }
        Ok(None)
    }

    fn facts(&self) -> Facts<'_> {
        Facts {
            path: &self.lines.path,
            line: self.lines.line,
            two_times: self.two_times,
            skipped: &self.skipped,
        }
    }
}

pub(super) fn se2([x_m, y_m, theta_rad]: Triple) -> SE2 {
    SE2::new(x_m, y_m, theta_rad)
}

/// Counts a type of message; a file of another kind has as many "types" as
/// lines, so only this many are told apart.
fn count(skipped: &mut BTreeMap<String, u64>, name: &str) {
    let mut name = excerpt(name);
    if skipped.len() >= MAX_TYPES && !skipped.contains_key(&name) {
        name = "(others)".to_owned();
    }
    *skipped.entry(name).or_default() += 1;
}
