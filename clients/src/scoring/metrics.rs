//! How far the estimates are from the truth.
//!
//! Source: M. Grupp, *evo* (Python package, 1.38.1). The absolute trajectory
//! error is its `evo_ape --pose_relation trans_part` without alignment, the
//! relative pose error its `evo_rpe --delta 1 --delta_unit f` (consecutive
//! pairs), translation part and `angle_deg`.
//!
//! Departures: poses are planar; and where evo pairs time stamps, a tick here is
//! scored when it has both a true and an estimated pose made of numbers.
//! Everything else (a recording's ticks between two scans, say) is passed over,
//! and a pair of the relative error is two scored ticks with none between.

use rusty_contract::score::Score;
use rusty_geometry::{SE2, trig, wrap_angle};

use super::trace::RunTrace;

/// A scored tick: truth and estimate, world frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scored {
    /// Index of the tick.
    pub tick: usize,
    truth: SE2,
    estimate: SE2,
}

impl Scored {
    /// Distance between estimate and truth, m.
    pub fn position_error_m(&self) -> f64 {
        distance_m(&self.estimate, &self.truth)
    }

    /// Heading of the estimate less heading of the truth, rad in (−π, π].
    pub fn heading_error_rad(&self) -> f64 {
        wrap_angle(self.estimate.theta() - self.truth.theta())
    }
}

/// The scored ticks of an estimator (index of its name), in order.
pub(super) fn scored(trace: &RunTrace, estimator: usize) -> impl Iterator<Item = Scored> {
    (0..trace.ticks()).filter_map(move |tick| {
        let truth = trace.true_pose(tick)?;
        let estimate = trace.estimate(estimator, tick)?;
        Some(Scored { tick, truth, estimate })
    })
}

/// Distance truly driven, m: the sum of the straight steps from each known true
/// pose to the next.
#[must_use]
pub fn distance_driven_m(trace: &RunTrace) -> f64 {
    let mut known = (0..trace.ticks()).filter_map(|tick| trace.true_pose(tick));
    let Some(mut last) = known.next() else {
        return 0.0;
    };
    let mut sum_m = 0.0;
    for pose in known {
        sum_m += distance_m(&last, &pose);
        last = pose;
    }
    sum_m
}

/// One score per estimator, in roster order. A figure is `None` where nothing
/// was scored that it could be made of: all of them without a scored tick, the
/// relative ones with a single one, the drift in percent of a robot that stood.
#[must_use]
pub fn score(trace: &RunTrace) -> Vec<Score> {
    let driven_m = distance_driven_m(trace);
    (0..trace.names.len()).map(|i| score_one(trace, i, driven_m)).collect()
}

fn score_one(trace: &RunTrace, estimator: usize, driven_m: f64) -> Score {
    let ticks: Vec<Scored> = scored(trace, estimator).collect();
    let mut errors_m: Vec<f64> = ticks.iter().map(Scored::position_error_m).collect();
    let given = (0..trace.ticks()).filter(|&k| trace.estimate(estimator, k).is_some()).count();
    let (rpe_m, rpe_deg): (Vec<f64>, Vec<f64>) =
        ticks.windows(2).map(|pair| relative_error(&pair[0], &pair[1])).unzip();
    let last = ticks.last();
    let final_m = last.map(Scored::position_error_m);
    let mean_drift_m = mean(errors_m.iter().copied());
    let ate_rmse_m = rmse(&errors_m);
    Score {
        name: trace.names[estimator].clone(),
        scored_ticks: ticks.len() as u64,
        unscored_ticks: (trace.ticks() - given) as u64,
        final_position_error_m: final_m,
        final_heading_error_deg: last.map(|s| s.heading_error_rad().abs().to_degrees()),
        mean_drift_m,
        p95_drift_m: percentile(&mut errors_m, 0.95),
        ate_rmse_m,
        rpe_rmse_m: rmse(&rpe_m),
        rpe_rmse_deg: rmse(&rpe_deg),
        distance_m: driven_m,
        drift_percent: final_m.filter(|_| driven_m > 0.0).map(|m| 100.0 * m / driven_m),
    }
}

/// What the motion from one scored tick to the next was believed wrong by,
/// (m, degrees): E = (r_i⁻¹ r_j)⁻¹ (e_i⁻¹ e_j) for truths r and estimates e.
fn relative_error(i: &Scored, j: &Scored) -> (f64, f64) {
    let true_motion = i.truth.inverse() * j.truth;
    let believed_motion = i.estimate.inverse() * j.estimate;
    let error = true_motion.inverse() * believed_motion;
    (trig::hypot(error.x(), error.y()), error.theta().abs().to_degrees())
}

fn distance_m(a: &SE2, b: &SE2) -> f64 {
    trig::hypot(a.x() - b.x(), a.y() - b.y())
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> Option<f64> {
    let count = values.len();
    (count > 0).then(|| values.sum::<f64>() / count as f64)
}

fn rmse(values: &[f64]) -> Option<f64> {
    mean(values.iter().map(|v| v * v)).map(f64::sqrt)
}

/// The value at `fraction` of the way through the sorted values, linear between
/// ranks (numpy's default). Sorts.
fn percentile(values: &mut [f64], fraction: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let rank = fraction * values.len().checked_sub(1)? as f64;
    let low = values[rank.floor() as usize];
    let high = values[rank.ceil() as usize];
    Some(low + (high - low) * (rank - rank.floor()))
}

#[cfg(test)]
#[path = "metrics_tests.rs"]
mod tests;
