//! How far a trajectory is from the true one, in the figures that *evo* gives.

use serde::{Deserialize, Serialize};

/// What a row of errors comes to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// How many errors.
    pub count: u64,
    /// Root of the mean square.
    pub rmse: f64,
    /// Mean.
    pub mean: f64,
    /// Median (of an even number the mean of the two in the middle). Of more
    /// than 131,072 errors (translations as they are: 1,048,576) it is right to
    /// 1/4096 of itself.
    pub median: f64,
    /// Standard deviation, divided by the count.
    pub std: f64,
    /// The least.
    pub min: f64,
    /// The greatest.
    pub max: f64,
    /// Sum of the squares.
    pub sse: f64,
}

/// Errors of poses: how far off, and how much turned.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseErrors {
    /// Length of the translation, m.
    pub translation_m: Statistics,
    /// Angle of the rotation, rad, 0 to π.
    pub rotation_rad: Statistics,
}

/// How an estimate is laid over the truth before it is judged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Alignment {
    /// As it is.
    #[default]
    None,
    /// Moved as a whole so that the squares of the translations are least.
    Se2,
}

impl Alignment {
    /// The word for people.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Se2 => "SE(2)",
        }
    }
}

/// Absolute trajectory error, by how the estimate was laid over the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AbsoluteErrors {
    /// As it is.
    pub none: Option<PoseErrors>,
    /// With the first estimate on the first truth.
    pub origin: Option<PoseErrors>,
    /// Moved as a whole (SE(2)) so that the squares of the translations are
    /// least. Of a run of more than 131,072 ticks, over those that are kept to
    /// be drawn: `count` says how many.
    pub se2: Option<PoseErrors>,
}

/// Relative pose error, by the length of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RelativeErrors {
    /// From one scored tick to the next.
    pub per_tick: Option<PoseErrors>,
    /// From one pose to the first that is a metre further along the true
    /// path, and on from there.
    pub per_metre: Option<PoseErrors>,
}
