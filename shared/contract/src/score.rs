//! What a scorer writes down (`score.json`) and a launcher prints.

mod compute;
mod consistency;
mod convergence;
mod figures;
mod goals;
mod numbers;
mod reference;
mod table;
mod trajectory;

pub use compute::{ComputeTimes, Durations};
pub use consistency::{Consistency, Verdict};
pub use convergence::{Convergence, Recovery, Within};
pub use figures::Figures;
pub use goals::GoalScore;
pub use numbers::{degrees, duration, mean_and_error, metres, seconds, share};
pub use reference::ReferenceNoise;
pub use table::ScoreTable;
pub use trajectory::{AbsoluteErrors, Alignment, PoseErrors, RelativeErrors, Statistics};

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::input;
use crate::json::{Json as _, json, json_tree, through_tree};
use crate::scenario::{Access, Participant};

/// The scores of a run: a separate document, in SI units and degrees where
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
    /// Ticks in which a wall or a body kept the robot where it was, by truth and command;
    /// `None` where the run was not simulated, or no tick has a truth.
    #[serde(default)]
    pub blocked_ticks: Option<u64>,
    /// Goals that the robot reached; `None` where the scorer has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goals: Option<GoalScore>,
    /// What NEES takes the true poses' own errors to be; none where they are exact.
    #[serde(default, skip_serializing_if = "ReferenceNoise::is_none")]
    pub reference: ReferenceNoise,
    /// Run digest, 32 hexadecimal digits.
    pub digest: String,
    /// One per estimator, in roster order.
    #[serde(deserialize_with = "through_tree")]
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

json!(ScoreReport);
json_tree!(Vec<Score>);

impl ScoreReport {
    /// Reads the scores of the run with this digest, or of any run.
    ///
    /// # Errors
    /// Why the file has no such scores.
    pub fn read(path: &Path, digest: Option<&str>) -> Result<Self, String> {
        let json = input::read(path).map_err(|e| e.to_string())?;
        let path = path.display();
        let report = Self::from_json(&json).map_err(|e| format!("{path}: {e}"))?;
        match digest {
            Some(digest) if digest != report.digest => {
                Err(format!("{path} has the digest of another run, {}", report.digest))
            }
            _ => Ok(report),
        }
    }
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
    /// Scored ticks with a wrong estimate: its position is more than 0.5 m off, and four
    /// standard deviations of its covariance, if it has one, do not cover that.
    pub wrong_ticks: u64,
    /// Distance between the last scored estimate and its truth, m.
    pub final_position_error_m: Option<f64>,
    /// Heading error there, degrees, 0 to 180.
    pub final_heading_error_deg: Option<f64>,
    /// The same in rad, 0 to π.
    #[serde(default)]
    pub final_heading_error_rad: Option<f64>,
    /// Mean distance over all scored ticks, m.
    pub mean_position_error_m: Option<f64>,
    /// 95th percentile of it, m (linear between ranks). Of more than 1,048,576
    /// scored ticks it is right to 1/4096 of itself.
    pub p95_position_error_m: Option<f64>,
    /// The greatest distance, m.
    #[serde(default)]
    pub max_position_error_m: Option<f64>,
    /// Root of the mean square of the heading error, rad.
    #[serde(default)]
    pub rmse_heading_error_rad: Option<f64>,
    /// The greatest heading error, rad, 0 to π.
    #[serde(default)]
    pub max_heading_error_rad: Option<f64>,
    /// Absolute trajectory error: rmse of the translation part, m, no alignment.
    pub ate_rmse_m: Option<f64>,
    /// Relative pose error from one scored tick to the next: rmse of the
    /// translation part, m.
    pub rpe_rmse_m: Option<f64>,
    /// The same, rotation part, degrees.
    pub rpe_rmse_deg: Option<f64>,
    /// Distance truly driven, m: from the start of a simulated run, and from the first
    /// truth of a recording, to the last truth.
    pub distance_m: f64,
    /// Final position error, without alignment, of the distance driven, percent. `None`
    /// where the error is not one of driving: of less than 1 m, of a robot that was
    /// kidnapped, and of an estimator that is not told where it starts.
    pub drift_percent: Option<f64>,
    /// What it was told of the world.
    #[serde(default)]
    pub told: PriorKnowledge,
    /// The alignment that it is judged by: SE(2) if it is not told where it starts.
    #[serde(default)]
    pub alignment: Alignment,
    /// The errors after alignment in SE(2), over the ticks of `ate.se2`.
    #[serde(default)]
    pub aligned: Figures,
    /// Absolute trajectory error, all figures.
    #[serde(default)]
    pub ate: AbsoluteErrors,
    /// Relative pose error, all figures.
    #[serde(default)]
    pub rpe: RelativeErrors,
    /// Errors compared with the reported covariances; `None` (unscored) where none was
    /// reported, or none that could be used.
    #[serde(default)]
    pub nees: Option<Consistency>,
    /// Innovations compared with their covariances; `None` where none was reported.
    #[serde(default)]
    pub nis: Option<Consistency>,
    /// When it found the robot; `None` without a scored tick.
    #[serde(default)]
    pub convergence: Option<Convergence>,
    /// How long its answers took; `None` for what was read from a log.
    #[serde(default)]
    pub compute: Option<ComputeTimes>,
}

impl Score {
    /// The errors by this alignment.
    #[must_use]
    pub fn figures(&self, alignment: Alignment) -> Figures {
        match alignment {
            Alignment::Se2 => self.aligned,
            Alignment::None => Figures {
                final_position_error_m: self.final_position_error_m,
                final_heading_error_rad: self.final_heading_error_rad,
                mean_position_error_m: self.mean_position_error_m,
                p95_position_error_m: self.p95_position_error_m,
                max_position_error_m: self.max_position_error_m,
                ate_rmse_m: self.ate_rmse_m,
                rmse_heading_error_rad: self.rmse_heading_error_rad,
                max_heading_error_rad: self.max_heading_error_rad,
            },
        }
    }
}

/// What an estimator was told of the world when it joined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PriorKnowledge {
    /// The map.
    pub map: Access,
    /// Where it starts.
    pub initial_pose: Access,
}

impl PriorKnowledge {
    /// The alignment by which a participant that was told this is judged: who is not told where it
    /// starts has a separate frame.
    #[must_use]
    pub fn alignment(self) -> Alignment {
        match self.initial_pose {
            Access::Given => Alignment::None,
            Access::Hidden => Alignment::Se2,
        }
    }
}

impl From<&Participant> for PriorKnowledge {
    fn from(participant: &Participant) -> Self {
        Self { map: participant.map, initial_pose: participant.initial_pose }
    }
}
