//! Whether an estimator's errors are as large as it says they are.

use serde::{Deserialize, Serialize};

/// Normalised squared errors (NEES) or innovations (NIS) of one run, compared with
/// what they would be if the estimator's covariances were right.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Consistency {
    /// How many were taken.
    pub samples: u64,
    /// How many could not be: their covariance was no covariance of full rank.
    pub unusable: u64,
    /// Degrees of freedom, summed over the samples (3 for each pose).
    pub degrees: f64,
    /// Sum of the samples.
    pub sum: f64,
    /// Mean over the samples; expected: `degrees / samples`.
    pub mean: f64,
    /// The last one: across runs these are independent of each other.
    pub last: f64,
    /// Degrees of freedom of the last.
    pub last_degrees: f64,
    /// Share of the samples in the two-sided band of their degrees, at
    /// `level`.
    pub share_within: f64,
    /// As many independent samples would be as uncertain as these are together:
    /// estimated for errors, which drag on from tick to tick; all of them for
    /// innovations, which a right filter makes independent.
    pub effective_samples: f64,
    /// The mean is in here with probability `level` if all is right.
    pub interval: [f64; 2],
    /// Probability of the interval and of the band, e.g. 0.95.
    pub level: f64,
    /// What follows from mean and interval.
    pub verdict: Verdict,
}

/// What an estimator says of its errors, compared with what they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// They are as large as it says.
    Consistent,
    /// They are larger: the mean lies above the interval.
    Overconfident,
    /// They are smaller: the mean lies below the interval.
    Conservative,
}

impl Verdict {
    /// What a mean and its acceptance interval say.
    #[must_use]
    pub fn of(mean: f64, [low, high]: [f64; 2]) -> Self {
        match mean {
            m if m > high => Self::Overconfident,
            m if m < low => Self::Conservative,
            _ => Self::Consistent,
        }
    }

    /// The word used in files and messages.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Consistent => "consistent",
            Self::Overconfident => "overconfident",
            Self::Conservative => "conservative",
        }
    }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.word())
    }
}
