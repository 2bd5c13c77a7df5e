//! The two systematic errors of a differential drive.

use rusty_contract::RobotConfig;
use serde::Serialize;

/// E_b and E_d: what is, over what is believed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Factors {
    /// E_b: actual over nominal wheelbase.
    pub wheelbase: f64,
    /// E_d: diameter of the right over that of the left wheel.
    pub diameters: f64,
}

impl Factors {
    /// Those of a robot, as far as a square can show them.
    ///
    /// A closed path closes whatever its scale. A robot whose wheels are both
    /// too large drives a larger square, and turns too far on its corners just
    /// as if its wheelbase were shorter; so what the corners show is the
    /// wheelbase over the mean wheel. With a right wheel of r·(1 + δ) the mean
    /// is larger by the factor 1 + δ/2. The scale itself is found by driving a
    /// straight line next to a tape measure, as the paper says.
    #[must_use]
    pub fn of(robot: &RobotConfig) -> Self {
        Self {
            wheelbase: (1.0 + robot.track_bias) / (1.0 + 0.5 * robot.radius_bias_right),
            diameters: 1.0 + robot.radius_bias_right,
        }
    }

    /// What left and right wheel are to be multiplied with, so that their ratio
    /// is E_d and their mean stays.
    #[must_use]
    pub fn wheels(&self) -> [f64; 2] {
        [2.0 / (self.diameters + 1.0), 2.0 / (1.0 / self.diameters + 1.0)]
    }
}
