//! How far the estimates are from the truth.
//!
//! A [`Meter`] sees the ticks of a run one by one and keeps sums: it takes the
//! same memory for any number of them, but for the 95th percentile
//! ([`quantile`](rusty_contract::score::quantile) says how that is kept).
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
    let mut meter = Meter::new(&trace.names, trace.ticks() as u64);
    for tick in 0..trace.ticks() {
        let estimates = (0..trace.names.len()).map(|i| trace.estimate(i, tick));
        meter.push(trace.true_pose(tick), estimates);
    }
    meter.scores()
}

/// What is measured of a run, tick by tick.
#[derive(Clone, Debug)]
pub struct Meter {
    ticks: u64,
    ticks_with_truth: u64,
    driven: PathLength,
    estimators: Vec<Sums>,
}

/// What is kept of one estimator.
#[derive(Clone, Debug)]
struct Sums {
    name: String,
    /// Ticks with an estimate.
    given: u64,
    last: Option<Scored>,
    errors: Errors,
    pairs: u64,
    relative_m2: f64,
    relative_deg2: f64,
}

impl Meter {
    /// A run of which no tick has been seen, and `ticks` are to come. Seeing as
    /// many allocates nothing.
    #[must_use]
    pub fn new(names: &[String], ticks: u64) -> Self {
        let sums = |name: &String| Sums {
            name: name.clone(),
            given: 0,
            last: None,
            errors: Errors::expecting(ticks),
            pairs: 0,
            relative_m2: 0.0,
            relative_deg2: 0.0,
        };
        let estimators = names.iter().map(sums).collect();
        Self { ticks: 0, ticks_with_truth: 0, driven: PathLength::default(), estimators }
    }

    /// Adds a tick. `estimates` come in the order of the names; those that are
    /// missing at the end count as not given, and more of them than names are
    /// left aside. So are poses that are no numbers.
    pub fn push(&mut self, truth: Option<SE2>, estimates: impl Iterator<Item = Option<SE2>>) {
        let tick = self.ticks as usize;
        self.ticks += 1;
        let truth = truth.filter(SE2::is_finite);
        if let Some(pose) = truth {
            self.ticks_with_truth += 1;
            self.driven.push(&pose);
        }
        for (sums, estimate) in self.estimators.iter_mut().zip(estimates) {
            let Some(estimate) = estimate.filter(SE2::is_finite) else { continue };
            sums.given += 1;
            if let Some(truth) = truth {
                sums.push(Scored { tick, truth, estimate });
            }
        }
    }

    /// Ticks seen.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.ticks
    }

    /// Those of them that have a true pose.
    #[must_use]
    pub fn ticks_with_truth(&self) -> u64 {
        self.ticks_with_truth
    }

    /// Distance truly driven, m; see [`distance_driven_m`].
    #[must_use]
    pub fn driven_m(&self) -> f64 {
        self.driven.metres()
    }

    /// One score per estimator, in the order of the names; see [`score()`].
    #[must_use]
    pub fn scores(&mut self) -> Vec<Score> {
        let (ticks, driven_m) = (self.ticks, self.driven.metres());
        self.estimators.iter_mut().map(|sums| sums.score(ticks, driven_m)).collect()
    }
}

impl Sums {
    fn push(&mut self, scored: Scored) {
        self.errors.push(&scored.estimate, &scored.truth);
        if let Some(last) = self.last.replace(scored) {
            let (error_m, error_deg) = relative_error(&last, &scored);
            self.pairs += 1;
            self.relative_m2 += error_m * error_m;
            self.relative_deg2 += error_deg * error_deg;
        }
    }

    fn score(&mut self, ticks: u64, driven_m: f64) -> Score {
        let figures = self.errors.figures();
        let final_m = figures.final_position_error_m;
        Score {
            name: self.name.clone(),
            scored_ticks: self.errors.ticks(),
            unscored_ticks: ticks - self.given,
            final_position_error_m: final_m,
            final_heading_error_deg: figures.final_heading_error_rad.map(f64::to_degrees),
            final_heading_error_rad: figures.final_heading_error_rad,
            mean_drift_m: figures.mean_drift_m,
            p95_drift_m: figures.p95_drift_m,
            max_drift_m: figures.max_drift_m,
            heading_rmse_rad: figures.heading_rmse_rad,
            heading_max_rad: figures.heading_max_rad,
            ate_rmse_m: figures.ate_rmse_m,
            rpe_rmse_m: root_mean(self.relative_m2, self.pairs),
            rpe_rmse_deg: root_mean(self.relative_deg2, self.pairs),
            distance_m: driven_m,
            drift_percent: final_m.filter(|_| driven_m > 0.0).map(|m| 100.0 * m / driven_m),
            ..Score::default()
        }
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

fn root_mean(sum: f64, count: u64) -> Option<f64> {
    (count > 0).then(|| (sum / count as f64).sqrt())
}

#[cfg(test)]
#[path = "metrics_tests.rs"]
mod tests;
