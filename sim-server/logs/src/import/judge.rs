//! Odometry compared with the corrected poses of a recording.

use rusty_geometry::SE2;

use super::recording::Event;
use super::wheels::distance_m;

/// Distance from which a pose has moved, m. A scan matcher's noise is less.
const MOVED_M: f64 = 0.05;
/// Angle from which a pose has turned, rad.
const TURNED_RAD: f64 = 0.05;

/// An interval between scans without odometry.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gap {
    pub(super) line: u64,
    pub(super) turn_rad: f64,
    pub(super) distance_m: f64,
    pub(super) gap_s: f64,
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
}

impl Judge {
    /// Takes an event, and the body's corrected pose where it is a scan.
    pub(super) fn take(&mut self, event: &Event<'_>, truth: Option<SE2>) {
        let (stamp_s, odometry, line) = match event {
            Event::Anchor { .. } => return,
            Event::Reading { .. } => {
                self.has_odometry = true;
                return;
            }
            Event::Scan { stamp_s, odometry, line, .. } => (*stamp_s, odometry, *line),
        };
        let Some(pose) = truth else { return };
        let has_odometry = std::mem::take(&mut self.has_odometry) || odometry.is_some();
        let step_m = distance_m(self.path_from.get_or_insert(pose), &pose);
        if step_m > MOVED_M {
            self.path_from = Some(pose);
            self.path_m += step_m;
        }
        if let Some((last, last_s)) = self.last.replace((pose, stamp_s)) {
            self.intervals += 1;
            let turn_rad = pose.boxminus(&last).z;
            let gap = Gap {
                line,
                turn_rad,
                distance_m: distance_m(&last, &pose),
                gap_s: stamp_s - last_s,
            };
            if !has_odometry && (gap.distance_m > MOVED_M || turn_rad.abs() > TURNED_RAD) {
                self.missing += 1;
                if self.worst.is_none_or(|worst| turn_rad.abs() > worst.turn_rad.abs()) {
                    self.worst = Some(gap);
                }
            }
        }
    }
}
