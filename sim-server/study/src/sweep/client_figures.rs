//! The figures that only a run with clients has: those of the scorer that the
//! rows made inside lack.

use rusty_contract::score::{Convergence, Durations, GoalScore, PoseErrors, Score};
use serde::{Deserialize, Serialize};

/// What [`Score`] says beyond the figures of every row. NaN where nothing was
/// scored, reported or found that one could be made of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClientFigures {
    /// Ticks with an estimate and a truth.
    pub scored_ticks: u64,
    /// Those of them with an estimate that is far off without a warning.
    pub wrong_ticks: u64,
    /// Absolute trajectory error with the first estimate on the first truth:
    /// rmse of the translation, m.
    pub ate_origin_rmse_m: f64,
    /// The same after alignment in SE(2), m.
    pub ate_se2_rmse_m: f64,
    /// Relative pose error from tick to tick: rmse of the translation, m.
    pub rpe_per_tick_rmse_m: f64,
    /// The same, rotation, rad.
    pub rpe_per_tick_rmse_rad: f64,
    /// Relative pose error per metre: rmse of the translation, m.
    pub rpe_per_metre_rmse_m: f64,
    /// The same, rotation, rad.
    pub rpe_per_metre_rmse_rad: f64,
    /// Ticks with a NEES; 0 where no covariance was reported.
    pub nees_samples: u64,
    /// Their mean; 3 is right.
    pub nees_mean: f64,
    /// The last one.
    pub nees_last: f64,
    /// Innovations that were reported.
    pub nis_samples: u64,
    /// Sum of their NIS.
    pub nis_sum: f64,
    /// Sum of their degrees of freedom: what the sum should be.
    pub nis_degrees: f64,
    /// From the start until the estimate had found the robot, s.
    pub converged_after_s: f64,
    /// From the first kidnapping until it had found it again, s.
    pub recovered_after_s: f64,
    /// Compute time as the estimator reports it, median, s.
    pub compute_reported_p50_s: f64,
    /// The same, 99th percentile, s.
    pub compute_reported_p99_s: f64,
    /// From frame to answer as the server sees it, median, s.
    pub compute_observed_p50_s: f64,
    /// The same, 99th percentile, s.
    pub compute_observed_p99_s: f64,
    /// Time until the robot had been at all goals of the scorer, s; NaN if it had not.
    pub goals_after_s: f64,
    /// Distance truly driven until then, m.
    pub goals_driven_m: f64,
    /// Figures after it had found the robot.
    pub found: Found,
}

/// How an estimator did once it had found the robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// Rmse of the position from there on, m; NaN where it never had.
    pub position_rmse_m: f64,
    /// The same for the heading, rad.
    pub heading_rmse_rad: f64,
    /// How often the robot was carried away.
    pub kidnapped: u64,
    /// How often it was found again.
    pub recovered: u64,
}

impl Default for Found {
    /// Of a run of which nothing is known.
    fn default() -> Self {
        let nan = f64::NAN;
        Self { position_rmse_m: nan, heading_rmse_rad: nan, kidnapped: 0, recovered: 0 }
    }
}

impl Found {
    fn of(convergence: Option<&Convergence>) -> Self {
        let Some(c) = convergence else { return Self::default() };
        let recovered = c.recoveries.iter().filter(|r| r.after_s.is_some());
        Self {
            position_rmse_m: c.position_rmse_m.unwrap_or(f64::NAN),
            heading_rmse_rad: c.heading_rmse_rad.unwrap_or(f64::NAN),
            kidnapped: c.recoveries.len() as u64,
            recovered: recovered.count() as u64,
        }
    }
}

impl ClientFigures {
    /// Those of a score; of none, all are missing.
    #[must_use]
    pub fn of(score: Option<&Score>) -> Self {
        let nan = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let metres = |of: fn(&Score) -> Option<PoseErrors>| {
            nan(score.and_then(of).map(|e| e.translation_m.rmse))
        };
        let radians = |of: fn(&Score) -> Option<PoseErrors>| {
            nan(score.and_then(of).map(|e| e.rotation_rad.rmse))
        };
        let nees = score.and_then(|s| s.nees);
        let nis = score.and_then(|s| s.nis);
        let convergence = score.and_then(|s| s.convergence.as_ref());
        let took = |of: fn(&Score) -> Option<Durations>, p: fn(Durations) -> f64| {
            nan(score.and_then(of).map(p))
        };
        let reported = |s: &Score| s.compute.map(|c| c.reported);
        let observed = |s: &Score| s.compute.map(|c| c.observed);
        Self {
            scored_ticks: score.map_or(0, |s| s.scored_ticks),
            wrong_ticks: score.map_or(0, |s| s.wrong_ticks),
            ate_origin_rmse_m: metres(|s| s.ate.origin),
            ate_se2_rmse_m: metres(|s| s.ate.se2),
            rpe_per_tick_rmse_m: metres(|s| s.rpe.per_tick),
            rpe_per_tick_rmse_rad: radians(|s| s.rpe.per_tick),
            rpe_per_metre_rmse_m: metres(|s| s.rpe.per_metre),
            rpe_per_metre_rmse_rad: radians(|s| s.rpe.per_metre),
            nees_samples: nees.map_or(0, |n| n.samples),
            nees_mean: nan(nees.map(|n| n.mean)),
            nees_last: nan(nees.map(|n| n.last)),
            nis_samples: nis.map_or(0, |n| n.samples),
            nis_sum: nan(nis.map(|n| n.sum)),
            nis_degrees: nan(nis.map(|n| n.degrees)),
            converged_after_s: nan(convergence.and_then(|c| c.after_s)),
            recovered_after_s: nan(convergence.and_then(|c| c.recoveries.first()?.after_s)),
            compute_reported_p50_s: took(reported, |d| d.p50_s),
            compute_reported_p99_s: took(reported, |d| d.p99_s),
            compute_observed_p50_s: took(observed, |d| d.p50_s),
            compute_observed_p99_s: took(observed, |d| d.p99_s),
            goals_after_s: f64::NAN,
            goals_driven_m: f64::NAN,
            found: Found::of(convergence),
        }
    }

    /// The same with the goals of the run.
    #[must_use]
    pub fn with_goals(self, goals: Option<GoalScore>) -> Self {
        let nan = |of: fn(GoalScore) -> Option<f64>| goals.and_then(of).unwrap_or(f64::NAN);
        Self { goals_after_s: nan(|g| g.after_s), goals_driven_m: nan(|g| g.driven_m), ..self }
    }
}
