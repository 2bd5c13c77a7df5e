//! What a scorer writes down (`score.json`) and a launcher prints.

pub mod chi_square;
mod compute;
mod consistency;
mod convergence;
mod errors;
pub mod nees;
pub mod quantile;
mod table;
mod trajectory;

pub use compute::{ComputeTimes, Durations};
pub use consistency::{Consistency, Verdict};
pub use convergence::{Convergence, Recovery, Within};
pub use errors::{Errors, Figures, PathLength, heading_error_rad, position_error_m};
pub use quantile::Quantiles;
pub use table::{ScoreTable, duration};
pub use trajectory::{AbsoluteErrors, PoseErrors, RelativeErrors, Statistics};

use serde::{Deserialize, Serialize};

/// The scores of a run: a document of its own, in SI units and degrees where
/// the name says so.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScoreReport {
    /// Name of the scenario.
    pub scenario: String,
    /// The seed, where the run was simulated.
    pub seed: Option<u64>,
    /// Ticks scored.
    pub ticks: u64,
    /// Ticks for which a true pose is known.
    pub ticks_with_truth: u64,
    /// Ticks in which a wall kept the robot where it was, by truth and command;
    /// `None` where the run was not simulated, or no tick has a truth.
    #[serde(default)]
    pub blocked_ticks: Option<u64>,
    /// Run digest, 32 hexadecimal digits.
    pub digest: String,
    /// One per estimator, in roster order.
    pub scores: Vec<Score>,
    /// Why there are none, where no tick has a truth to compare with.
    #[serde(default)]
    pub unscored: Option<String>,
    /// Pictures written, as paths.
    pub pictures: Vec<String>,
    /// The report written, as a path.
    #[serde(default)]
    pub report: Option<String>,
}

/// One estimator's scores against the truth.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Name in the roster.
    pub name: String,
    /// Ticks with an estimate and a truth.
    pub scored_ticks: u64,
    /// Ticks without an estimate.
    pub unscored_ticks: u64,
    /// Distance between the last scored estimate and its truth, m.
    pub final_position_error_m: Option<f64>,
    /// Heading error there, degrees, 0 to 180.
    pub final_heading_error_deg: Option<f64>,
    /// The same in rad, 0 to π.
    #[serde(default)]
    pub final_heading_error_rad: Option<f64>,
    /// Mean distance over all scored ticks, m.
    pub mean_drift_m: Option<f64>,
    /// 95th percentile of it, m (linear between ranks). Of more than 1,048,576
    /// scored ticks it is right to 1/4096 of itself.
    pub p95_drift_m: Option<f64>,
    /// The greatest distance, m.
    #[serde(default)]
    pub max_drift_m: Option<f64>,
    /// Root of the mean square of the heading error, rad.
    #[serde(default)]
    pub heading_rmse_rad: Option<f64>,
    /// The greatest heading error, rad, 0 to π.
    #[serde(default)]
    pub heading_max_rad: Option<f64>,
    /// Absolute trajectory error: rmse of the translation part, m, no alignment.
    pub ate_rmse_m: Option<f64>,
    /// Relative pose error from one scored tick to the next: rmse of the
    /// translation part, m.
    pub rpe_rmse_m: Option<f64>,
    /// The same, rotation part, degrees.
    pub rpe_rmse_deg: Option<f64>,
    /// Distance truly driven between the first and the last truth, m.
    pub distance_m: f64,
    /// Final position error per distance driven, percent.
    pub drift_percent: Option<f64>,
    /// Absolute trajectory error, all figures.
    #[serde(default)]
    pub ate: AbsoluteErrors,
    /// Relative pose error, all figures.
    #[serde(default)]
    pub rpe: RelativeErrors,
    /// Errors beside the reported covariances; `None` (unscored) where none was
    /// reported, or none that could be used.
    #[serde(default)]
    pub nees: Option<Consistency>,
    /// Innovations beside their covariances; `None` where none was reported.
    #[serde(default)]
    pub nis: Option<Consistency>,
    /// When it found the robot; `None` without a scored tick.
    #[serde(default)]
    pub convergence: Option<Convergence>,
    /// How long its answers took; `None` for what was read from a log.
    #[serde(default)]
    pub compute: Option<ComputeTimes>,
}
