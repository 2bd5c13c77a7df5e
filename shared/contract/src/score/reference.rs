//! `ReferenceNoise`: how exact the poses are that estimates are compared with.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The error of each true pose, independent from pose to pose: that of a simulation is zero;
/// that of a recording is an estimate itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReferenceNoise {
    /// Standard deviation of the position, each axis, m.
    pub std_m: f64,
    /// Standard deviation of the heading, rad.
    pub std_rad: f64,
}

impl ReferenceNoise {
    /// Whether the true poses are exact.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// The covariance of truth ⊟ estimate where that of the estimate is `covariance`, row by
    /// row: errors of truth and estimate are independent.
    #[must_use]
    pub fn added_to(&self, covariance: &[f64; 9]) -> [f64; 9] {
        let mut sum = *covariance;
        for (axis, std) in [(0, self.std_m), (4, self.std_m), (8, self.std_rad)] {
            sum[axis] += std * std;
        }
        sum
    }
}

impl fmt::Display for ReferenceNoise {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let deg = self.std_rad.to_degrees();
        write!(f, "NEES with true poses of {} m and {deg:.3} ° (standard deviations)", self.std_m)
    }
}
