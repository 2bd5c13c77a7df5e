//! The facts that decide how the lines of a recording are read: whether `ODOM`
//! lines echo scans, whether the stamps tell the time, and the parameters.
//!
//! A log that GMapping corrected holds the path of its best particle: an `ODOM`
//! line for each pose after a motion update, and for each scan that was matched
//! a `FLASER` and behind it one more `ODOM` line, which echoes the corrected
//! pose and whose time was never set (GMapping, gridfastslam/gfsreader.cpp,
//! `RecordList::printPath`). A writer that echoes, echoes every scan, so one
//! decision holds for the whole file. It is made before anything is written:
//! an echo that is taken for a reading puts the truth into the wheels.
//!
//! A file has echoes if the `ODOM` line behind a scan repeats its pose digit
//! for digit, and
//!
//! * the stamp of such a line cannot be its time: the writer never set it, so
//!   it is 0 or the bits that happened to lie there (1.08499e-42, or the range
//!   of some beam). One such line is enough, as is one with a `NEFF` line behind it
//!   (see `detached`);
//! * or most scans whose pose differs from the `ODOM` line before them are
//!   repeated, and either the stamps stand still, so that they decide nothing,
//!   or the steps into these scans are far more sideways than the other steps:
//!   corrections go anywhere, two wheels do not.
//!
//! One repeated pose alone does not decide: a robot that stands still repeats
//! the pose of its scan too.

use std::path::Path;

use super::Progress;
use super::carmen::{Message, Triple, parse};
use super::detached::{Detached, is_time_near};
use super::error::ImportError;
use super::lines::Lines;
use super::recording::se2;

/// Ratio of mean sideways motion from which steps into scans are corrections.
/// Measured on four logs with echoes: 4.7 to 134.
const SIDEWAYS_RATIO: f64 = 3.0;

/// Parameters that matter here, as far as the file has them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Params {
    /// `robot_frontlaser_offset`: laser before the axle, m.
    pub(super) laser_offset_m: Option<f64>,
    /// `robot_front_laser_max`: ranges from here on mean nothing came back, m.
    pub(super) laser_max_m: Option<f64>,
}

impl Params {
    /// Takes a parameter. A value that is not a number counts as absent: what
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

/// Stamps and how many of their intervals have length 0.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StampIntervals {
    last_s: Option<f64>,
    pub(super) intervals: u64,
    pub(super) standing: u64,
}

impl StampIntervals {
    pub(super) fn see(&mut self, stamp_s: f64) {
        if let Some(last_s) = self.last_s.replace(stamp_s) {
            self.intervals += 1;
            self.standing += u64::from(stamp_s == last_s);
        }
    }
}

/// A number of steps and the sum of their sideways parts, m.
#[derive(Clone, Copy, Debug, Default)]
struct Steps {
    number: u64,
    sideways_m: f64,
}

impl Steps {
    fn see(&mut self, from: Triple, to: Triple) {
        self.number += 1;
        self.sideways_m += se2(to).boxminus(&se2(from)).y.abs();
    }

    fn mean_m(&self) -> f64 {
        self.sideways_m / self.number as f64
    }
}

/// A recording, read once for what decides how its lines are understood.
#[derive(Debug, Default)]
pub(super) struct Preview {
    pub(super) params: Params,
    /// Lines of the file.
    pub(super) lines: u64,
    scan_stamps: StampIntervals,
    reading_stamps: StampIntervals,
    /// Pose of the last `ODOM` line.
    odometry: Option<Triple>,
    /// Pose and stamp of the scan before, until an `ODOM` line follows.
    scan: Option<(Triple, f64)>,
    /// Echoes whose stamp cannot be their time.
    stray: bool,
    /// Scans whose pose is not that of the `ODOM` line before them.
    moved: u64,
    /// Steps into those of them that the next `ODOM` line repeats.
    corrections: Steps,
    /// Steps between other `ODOM` lines.
    others: Steps,
    detached: Detached,
}

impl Preview {
    /// Reads the whole file.
    pub(super) fn read(path: &Path, progress: &mut Progress<'_>) -> Result<Self, ImportError> {
        let (mut lines, mut ranges_m) = (Lines::open(path)?, Vec::new());
        let mut preview = Self::default();
        let mut is_behind_odom = false;
        while lines.advance()? {
            let line = lines.line;
            progress.at(line);
            let was_behind_odom = std::mem::take(&mut is_behind_odom);
            match parse(&lines.path, line, &lines.text, &mut ranges_m)? {
                Message::Param { name, value } => preview.params.set(name, value),
                Message::Odom { pose, stamps } => {
                    preview.odom(pose, stamps.measured_s, line);
                    is_behind_odom = true;
                }
                Message::Flaser { pose, stamps, .. } => {
                    preview.scan = Some((pose, stamps.measured_s));
                    preview.scan_stamps.see(stamps.measured_s);
                    preview.detached.scan(stamps.measured_s);
                }
                Message::Other("NEFF") if was_behind_odom => preview.detached.mark(),
                Message::Blank => is_behind_odom = was_behind_odom,
                Message::Other(_) => {}
            }
        }
        preview.lines = lines.line;
        Ok(preview)
    }

    fn odom(&mut self, pose: Triple, stamp_s: f64, line: u64) {
        let before = self.odometry.replace(pose);
        if self.scan.is_some_and(|(scan, _)| scan == pose) {
            self.detached.echo();
        } else {
            self.detached.reading(stamp_s, line);
        }
        match (self.scan.take(), before) {
            (Some((scan, scan_s)), _) if pose == scan && !is_time_near(stamp_s, scan_s) => {
                self.stray = true;
            }
            (Some((scan, _)), Some(before)) if before != scan => {
                self.moved += 1;
                if pose == scan {
                    self.corrections.see(before, scan);
                }
            }
            (None, before) => {
                self.reading_stamps.see(stamp_s);
                if let Some(before) = before {
                    self.others.see(before, pose);
                }
            }
            _ => {}
        }
    }

    /// Whether the first `ODOM` line behind a scan is its echo if it repeats its
    /// pose.
    pub(super) fn has_echoes(&self) -> bool {
        let most = 2 * self.corrections.number > self.moved;
        let far_m = SIDEWAYS_RATIO * self.others.mean_m();
        let sure = self.stray || self.detached.is_marked();
        sure || most && (self.flat().is_some() || self.corrections.mean_m() > far_m)
    }

    /// The lines of further `ODOM` messages from which the odometry goes on, in order.
    pub(super) fn detached(&self) -> Vec<u64> {
        self.detached.lines(self.has_echoes(), self.flat().is_none())
    }

    /// The stamps of the scans (without scans: of the readings), if most of them
    /// repeat the one before.
    pub(super) fn flat(&self) -> Option<StampIntervals> {
        let stamps =
            if self.scan_stamps.intervals > 0 { self.scan_stamps } else { self.reading_stamps };
        (2 * stamps.standing > stamps.intervals).then_some(stamps)
    }
}
