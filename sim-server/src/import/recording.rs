//! What the lines mean together: readings, scans, and echoes of scans.
//!
//! A log that GMapping corrected holds the path of its best particle: an `ODOM`
//! line for each pose after a motion update, and for each scan that was matched
//! a `FLASER` and behind it one more `ODOM` line, which echoes the corrected
//! pose and whose time was never set (GMapping, gridfastslam/gfsreader.cpp,
//! `RecordList::printPath`). The `ODOM` lines that follow go on *from that
//! pose*. So such an echo is no reading of the odometry but an *anchor*, and the
//! odometry is the chain of increments, from line to line and across a scan from
//! the anchor to the next line. Taken as one path the `ODOM` lines would jump
//! sideways at every scan (up to 17 cm in the log of the Intel Research Lab)
//! and would never drift. The increments are the robot's own, without the noise
//! of a particle: in the Intel log 99.6 % of the turns are whole multiples of
//! one heading step, 6.1455 mrad.
//!
//! An `ODOM` line is an anchor if it is the first after a `FLASER`, repeats its
//! first pose digit for digit, and
//!
//! * its stamp cannot be its time: the writer never set it, so it is 0 or the
//!   bits that happened to lie there (1.08499e-42, or the range of some beam);
//! * or an anchor was found before: a writer that echoes, echoes every scan.
//!   Without this clause an echo would be believed whenever the stray bits look
//!   like a time (they do not in the two logs this was measured on).
//!
//! The poses alone do not tell: a robot that stands still repeats the pose of
//! its scan too, but with a good stamp.

use std::collections::BTreeMap;
use std::path::Path;

use rusty_geometry::SE2;

use super::carmen::{MEND, Message, Stamps, Triple, parse};
use super::error::{BadField, ImportError, excerpt};
use super::lines::Lines;

/// How far a stamp may lie before its scan's. In the log of the Intel Research
/// Lab real stamps fall back by up to 0.9 s.
const BEFORE_SCAN_S: f64 = 1.0;
/// How far a stamp may lie behind its scan's.
const AFTER_SCAN_S: f64 = 3600.0;
/// Stamps nearer to zero are no times, unless the scan's is the same.
const TINY_S: f64 = 1e-9;
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
        /// The first pose of the line: corrected, if anything is.
        pose: SE2,
        /// The odometry's own pose, where the line has one that differs.
        odometry: Option<SE2>,
        stamp_s: f64,
        /// As they stand in the file, m.
        ranges_m: &'a [f64],
        line: u64,
    },
}

impl Event<'_> {
    /// The line it stands in, from 1.
    pub(super) fn line(&self) -> u64 {
        match self {
            Self::Reading { line, .. } | Self::Anchor { line, .. } | Self::Scan { line, .. } => {
                *line
            }
        }
    }
}

/// Parameters that matter here, as far as the file has them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Params {
    /// `robot_frontlaser_offset`: laser before the axle, m.
    pub(super) laser_offset_m: Option<f64>,
    /// `robot_front_laser_max`: ranges from here on mean nothing came back, m.
    pub(super) laser_max_m: Option<f64>,
}

/// A CARMEN log, read event by event.
pub(super) struct Recording {
    lines: Lines,
    ranges_m: Vec<f64>,
    /// The scan before, until a reading follows: its first pose and its stamp.
    fresh_scan: Option<(Triple, f64)>,
    echoes: bool,
    params: Params,
    skipped: BTreeMap<String, u64>,
    two_times: u64,
}

impl Recording {
    /// Opens a log, plain or gzip.
    pub(super) fn open(path: &Path) -> Result<Self, ImportError> {
        Ok(Self {
            lines: Lines::open(path)?,
            ranges_m: Vec::new(),
            fresh_scan: None,
            echoes: false,
            params: Params::default(),
            skipped: BTreeMap::new(),
            two_times: 0,
        })
    }

    /// The log's path, for messages.
    pub(super) fn path(&self) -> &str {
        self.lines.path()
    }

    /// How many lines were read.
    pub(super) fn line(&self) -> u64 {
        self.lines.line()
    }

    /// Parameters found so far.
    pub(super) fn params(&self) -> Params {
        self.params
    }

    /// Messages of types that are not read, and how many of each.
    pub(super) fn skipped(&self) -> &BTreeMap<String, u64> {
        &self.skipped
    }

    /// Readings and scans whose two stamps differ.
    pub(super) fn two_times(&self) -> u64 {
        self.two_times
    }

    /// The next event, or `None` at the end of the file.
    pub(super) fn next_event(&mut self) -> Result<Option<Event<'_>>, ImportError> {
        while self.lines.advance()? {
            let (path, line) = (self.lines.path(), self.lines.line());
            match parse(path, line, self.lines.text(), &mut self.ranges_m)? {
                Message::Blank => {}
                Message::Other(name) => count(&mut self.skipped, name),
                Message::Param { name, value } => self.params.set(name, value),
                Message::Odom { pose, stamps } => return self.odom(pose, stamps).map(Some),
                Message::Flaser { pose, odometry, stamps } => {
                    self.two_times += u64::from(stamps.measured_s != stamps.logged_s);
                    self.fresh_scan = Some((pose, stamps.measured_s));
                    return Ok(Some(Event::Scan {
                        pose: se2(pose),
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

    fn odom(&mut self, pose: Triple, stamps: Stamps) -> Result<Event<'static>, ImportError> {
        let (stamp_s, line) = (stamps.measured_s, self.lines.line());
        if let Some((scan_pose, scan_s)) = self.fresh_scan.take()
            && pose == scan_pose
            && (self.echoes || !is_time_near(stamp_s, scan_s))
        {
            self.echoes = true;
            return Ok(Event::Anchor { pose: se2(pose), line });
        }
        if !stamp_s.is_finite() {
            return Err(ImportError::Field {
                path: self.lines.path().to_owned(),
                line,
                field: Box::new(BadField {
                    message: "ODOM",
                    field: 7,
                    name: "stamp".to_owned(),
                    found: stamp_s.to_string(),
                    problem: "is no time",
                    remedy: MEND,
                }),
            });
        }
        self.two_times += u64::from(stamp_s != stamps.logged_s);
        Ok(Event::Reading { pose: se2(pose), stamp_s, line })
    }
}

impl Params {
    /// Takes a parameter. A value that is no number is taken for none: what
    /// depends on it says what it assumes instead.
    fn set(&mut self, name: &str, value: &str) {
        let place = match name {
            "robot_frontlaser_offset" => &mut self.laser_offset_m,
            "robot_front_laser_max" => &mut self.laser_max_m,
            _ => return,
        };
        let number = value.parse::<f64>().ok();
        *place = number.filter(|value| value.is_finite());
    }
}

/// Whether a reading right after a scan can have this stamp.
fn is_time_near(stamp_s: f64, scan_s: f64) -> bool {
    let tiny = stamp_s.abs() < TINY_S && stamp_s != scan_s;
    let near = stamp_s >= scan_s - BEFORE_SCAN_S && stamp_s <= scan_s + AFTER_SCAN_S;
    near && !tiny
}

fn se2([x_m, y_m, theta_rad]: Triple) -> SE2 {
    SE2::new(x_m, y_m, theta_rad)
}

/// Counts a type of message; a file of another kind has as many "types" as
/// lines, so only so many are told apart.
fn count(skipped: &mut BTreeMap<String, u64>, name: &str) {
    let mut name = excerpt(name);
    if skipped.len() >= MAX_TYPES && !skipped.contains_key(&name) {
        name = "(others)".to_owned();
    }
    *skipped.entry(name).or_default() += 1;
}
