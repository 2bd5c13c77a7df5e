//! Findings: defects of a recording that change what a score on it means.

use rusty_contract::log::Finding;

use super::NOMINAL_RATE_HZ;
use super::survey::{Drive, Survey};

/// Part of the corrected path that odometry covers at least.
const COVERED_PART: f64 = 0.8;
/// Part of the odometry that may be sideways. Measured on two sound logs: 0.5 % and
/// 0.9 %; on three others: 6.8 % and more.
const SIDEWAYS_PART: f64 = 0.02;
/// A stamp may be earlier than the one before by this, s: messages of two sensors are not
/// always written in order. In the log of the Intel lab it is up to 0.9 s.
const BACKWARDS_S: f64 = 5.0;
/// Sideways motion that is too small to matter in all, and too large in one
/// step, m.
const SIDEWAYS_M: f64 = 0.1;

/// The findings about a recording, the most severe kind first.
pub(super) fn findings(survey: &Survey, drive: &Drive) -> Vec<Finding> {
    let (judge, wheels) = (&drive.judge, &drive.wheels);
    let (odometry_m, path_m) = (wheels.distance_m, judge.path_m);
    let flat = survey.flat.map(|stamps| Finding::FlatStamps {
        standing: stamps.standing,
        intervals: stamps.intervals,
        nominal_rate_hz: NOMINAL_RATE_HZ,
    });
    let is_backwards =
        survey.backwards.value > BACKWARDS_S || survey.last_stamp_s < survey.first_stamp_s;
    let backwards = is_backwards.then_some(Finding::BackwardStamps {
        backwards: survey.stamps_backwards,
        ticks: survey.tick_count(),
        max_s: survey.backwards.value,
        line: survey.backwards.line,
    });
    let gaps = judge.worst.map(|worst| Finding::NoOdometry {
        missing: judge.missing,
        intervals: judge.intervals,
        line: worst.line,
        turn_rad: worst.turn_rad,
        distance_m: worst.distance_m,
        gap_s: Some(worst.gap_s).filter(|s| survey.flat.is_none() && s.is_finite()),
    });
    // Without true poses, what the odometry itself says of its gaps is all there is.
    let without_truth = judge.worst_gap.filter(|_| judge.intervals == 0 && survey.flat.is_none());
    let own_gaps = without_truth.map(|worst| Finding::OdometryGap {
        gaps: judge.gaps,
        intervals: judge.readings,
        line: worst.line,
        turn_rad: worst.turn_rad,
        distance_m: worst.distance_m,
        gap_s: worst.gap_s,
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
    [gaps, own_gaps, short, flat, backwards, sideways, doubted].into_iter().flatten().collect()
}
