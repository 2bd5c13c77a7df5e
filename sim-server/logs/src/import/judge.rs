//! Odometry compared with the corrected poses of a recording, and its gaps in a recording
//! without such poses.

use rusty_geometry::SE2;

use super::recording::Event;
use super::wheels::distance_m;

/// Distance from which a pose has moved, m. A scan matcher's noise is less.
const MOVED_M: f64 = 0.05;
/// Angle from which a pose has turned, rad.
const TURNED_RAD: f64 = 0.05;

/// Time without odometry from which it is a gap, s. ROS drivers send 10 readings a second
/// and more.
const GAP_S: f64 = 1.0;

/// An interval between scans without odometry; or between two readings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gap {
    pub(super) line: u64,
    pub(super) turn_rad: f64,
    pub(super) distance_m: f64,
    pub(super) gap_s: f64,
}

impl Gap {
    /// The interval between two poses with their stamps, s, which ends at `line`.
    fn between((last, last_s): (SE2, f64), (pose, stamp_s): (SE2, f64), line: u64) -> Self {
        Self {
            line,
            turn_rad: pose.boxminus(&last).z,
            distance_m: distance_m(&last, &pose),
            gap_s: stamp_s - last_s,
        }
    }

    fn moves(&self) -> bool {
        self.distance_m > MOVED_M || self.turn_rad.abs() > TURNED_RAD
    }

    fn keep_worse_in(self, worst: &mut Option<Self>) {
        if worst.is_none_or(|worst| self.turn_rad.abs() > worst.turn_rad.abs()) {
            *worst = Some(self);
        }
    }
}

/// Odometry compared with the corrected poses of the scans.
#[derive(Debug, Default)]
pub(super) struct Judge {
    /// Pose and stamp of the last scan.
    last: Option<(SE2, f64)>,
    /// A reading came since then.
    has_odometry: bool,
    pub(super) intervals: u64,
    pub(super) missing: u64,
    pub(super) worst: Option<Gap>,
    /// The pose from which the path goes on.
    path_from: Option<SE2>,
    pub(super) path_m: f64,
    /// Pose and stamp of the last reading.
    last_reading: Option<(SE2, f64)>,
    /// Intervals between readings, and those in which the robot moves for long enough.
    pub(super) readings: u64,
    pub(super) gaps: u64,
    pub(super) worst_gap: Option<Gap>,
}

impl Judge {
    /// Takes an event, and the body's corrected pose where it is a scan.
    pub(super) fn take(&mut self, event: &Event<'_>, truth: Option<SE2>) {
        let (stamp_s, odometry, line) = match event {
            Event::Anchor { .. } => return,
            Event::Reading { pose, stamp_s, line } => {
                self.has_odometry = true;
                return self.reading(*pose, *stamp_s, *line);
            }
            Event::Scan { stamp_s, odometry, line, .. } => (*stamp_s, odometry, *line),
        };
        if let Some(pose) = odometry {
            self.reading(*pose, stamp_s, line);
        }
        let Some(pose) = truth else { return };
        let has_odometry = std::mem::take(&mut self.has_odometry) || odometry.is_some();
        let step_m = distance_m(self.path_from.get_or_insert(pose), &pose);
        if step_m > MOVED_M {
            self.path_from = Some(pose);
            self.path_m += step_m;
        }
        if let Some(last) = self.last.replace((pose, stamp_s)) {
            self.intervals += 1;
            let gap = Gap::between(last, (pose, stamp_s), line);
            if !has_odometry && gap.moves() {
                self.missing += 1;
                gap.keep_worse_in(&mut self.worst);
            }
        }
    }
    /// Takes a reading of the odometry.
    fn reading(&mut self, pose: SE2, stamp_s: f64, line: u64) {
        let Some(last) = self.last_reading.replace((pose, stamp_s)) else { return };
        self.readings += 1;
        let gap = Gap::between(last, (pose, stamp_s), line);
        if gap.gap_s > GAP_S && gap.moves() {
            self.gaps += 1;
            gap.keep_worse_in(&mut self.worst_gap);
        }
    }
}
