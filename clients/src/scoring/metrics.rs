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

use rusty_contract::score::{self, Errors, PathLength, Score};
use rusty_geometry::{SE2, trig};

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
        score::position_error_m(&self.estimate, &self.truth)
    }

    /// Heading of the estimate less heading of the truth, rad in (−π, π].
    pub fn heading_error_rad(&self) -> f64 {
        score::heading_error_rad(&self.estimate, &self.truth)
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
    let mut path = PathLength::default();
    (0..trace.ticks()).filter_map(|tick| trace.true_pose(tick)).for_each(|pose| path.push(&pose));
    path.metres()
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
    let mut errors = Errors::default();
    ticks.iter().for_each(|s| errors.push(&s.estimate, &s.truth));
    let figures = errors.figures();
    let given = (0..trace.ticks()).filter(|&k| trace.estimate(estimator, k).is_some()).count();
    let (rpe_m, rpe_deg): (Vec<f64>, Vec<f64>) =
        ticks.windows(2).map(|pair| relative_error(&pair[0], &pair[1])).unzip();
    let final_m = figures.final_position_error_m;
    Score {
        name: trace.names[estimator].clone(),
        scored_ticks: ticks.len() as u64,
        unscored_ticks: (trace.ticks() - given) as u64,
        final_position_error_m: final_m,
        final_heading_error_deg: figures.final_heading_error_rad.map(f64::to_degrees),
        final_heading_error_rad: figures.final_heading_error_rad,
        mean_drift_m: figures.mean_drift_m,
        p95_drift_m: figures.p95_drift_m,
        max_drift_m: figures.max_drift_m,
        heading_rmse_rad: figures.heading_rmse_rad,
        heading_max_rad: figures.heading_max_rad,
        ate_rmse_m: figures.ate_rmse_m,
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

fn rmse(values: &[f64]) -> Option<f64> {
    let squares: f64 = values.iter().map(|v| v * v).sum();
    (!values.is_empty()).then(|| (squares / values.len() as f64).sqrt())
}

#[cfg(test)]
#[path = "metrics_tests.rs"]
mod tests;
