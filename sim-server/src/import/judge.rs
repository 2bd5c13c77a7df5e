//! Findings: defects of a recording that change what a score on it means.

use rusty_contract::log::Finding;
use rusty_geometry::SE2;

use super::plan::NOMINAL_RATE_HZ;
use super::recording::Event;
use super::survey::{Drive, Survey, distance_m};

/// Distance from which a pose has moved, m. A scan matcher's noise is less.
const MOVED_M: f64 = 0.05;
/// Angle from which a pose has turned, rad.
const TURNED_RAD: f64 = 0.05;
/// Part of the corrected path that odometry covers at least.
const COVERED_PART: f64 = 0.8;
/// Part of the odometry that may be sideways. Measured on two sound logs: 0.5 % and
/// 0.9 %; on three others: 6.8 % and more.
const SIDEWAYS_PART: f64 = 0.02;
/// Sideways motion that is too small to matter in all, and too large in one
/// step, m.
const SIDEWAYS_M: f64 = 0.1;

/// An interval between scans without odometry.
#[derive(Clone, Copy, Debug)]
struct Gap {
    line: u64,
    turn_rad: f64,
    distance_m: f64,
    gap_s: f64,
}

/// Odometry compared with the corrected poses of the scans.
#[derive(Debug, Default)]
pub(super) struct Judge {
    /// Pose and stamp of the last scan.
    last: Option<(SE2, f64)>,
    /// A reading came since then.
    has_odometry: bool,
    intervals: u64,
    missing: u64,
    worst: Option<Gap>,
    /// The pose from which the path goes on.
    path_from: Option<SE2>,
    path_m: f64,
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

/// The findings about a recording, the most severe kind first.
pub(super) fn findings(survey: &Survey, drive: &Drive) -> Vec<Finding> {
    let (judge, wheels) = (&drive.judge, &drive.wheels);
    let (odometry_m, path_m) = (wheels.distance_m, judge.path_m);
    let flat = survey.flat.map(|stamps| Finding::FlatStamps {
        standing: stamps.standing,
        intervals: stamps.intervals,
        nominal_rate_hz: NOMINAL_RATE_HZ,
    });
    let gaps = judge.worst.map(|worst| Finding::NoOdometry {
        missing: judge.missing,
        intervals: judge.intervals,
        line: worst.line,
        turn_rad: worst.turn_rad,
        distance_m: worst.distance_m,
        gap_s: Some(worst.gap_s).filter(|s| survey.flat.is_none() && s.is_finite()),
    });
    let short = (odometry_m < COVERED_PART * path_m)
        .then_some(Finding::ShortOdometry { odometry_m, path_m });
    let (total_m, max) = (wheels.lateral_total_m, wheels.lateral);
    let is_part = total_m > SIDEWAYS_PART * odometry_m && total_m > SIDEWAYS_M;
    let sideways = (is_part || max.value > SIDEWAYS_M).then_some(Finding::Sideways {
        total_m,
        odometry_m,
        max_m: max.value,
        line: max.line,
    });
    let range_max = survey.ranges.max();
    let doubted = range_max.doubted.map(|(parameter_m, exceeding)| Finding::RangeMaxDoubted {
        parameter_m,
        exceeding,
        ranges: survey.ranges.all,
        used_m: range_max.m,
    });
    [gaps, short, flat, sideways, doubted].into_iter().flatten().collect()
}
