//! The robot: what its maker says of it, and what is true of it.

use rusty_geometry::DiffDrive;
use serde::{Deserialize, Serialize};

use super::slip::outlier_factor;
use super::{FieldError, SlipFigures, within};

/// The robot of a run, true parameters included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RobotConfig {
    /// Nominal wheel radius r, m. The left wheel is exactly this large.
    pub wheel_radius_m: f64,
    /// Nominal distance ℓ between the wheels' contact points, m.
    pub track_m: f64,
    /// Radius of the body's disc, m; it is what touches walls.
    pub body_radius_m: f64,
    /// Encoder counts N per wheel revolution.
    pub ticks_per_rev: u64,
    /// Fastest a wheel can turn, rad/s; commands beyond it are scaled down.
    pub wheel_limit_rad_s: f64,
    /// σ of the slip ε per wheel and *tick* (not scaled by √dt, on purpose).
    pub slip_std: f64,
    /// σ of the left wheel, where it is not `slip_std`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slip_std_left: Option<f64>,
    /// σ of the right wheel, where it is not `slip_std`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slip_std_right: Option<f64>,
    /// Probability of an outlier among the slips; see [`SlipFigures`]. Not written
    /// where it is 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub slip_outlier_rate: f64,
    /// How many times as large an outlier is. Not written where it is the default.
    #[serde(skip_serializing_if = "is_usual_factor")]
    pub slip_outlier_factor: f64,
    /// δ: the right wheel is really r·(1 + δ). Odometry never learns this.
    pub radius_bias_right: f64,
    /// ε: the wheels' contact points are really ℓ·(1 + ε) apart. Odometry never
    /// learns this either. Not written where it is 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub track_bias: f64,
}

/// Whether nothing is lost if it is not written.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it like this")]
fn is_zero(value: &f64) -> bool {
    value.to_bits() == 0
}

/// Whether nothing is lost if it is not written.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it like this")]
fn is_usual_factor(value: &f64) -> bool {
    value.to_bits() == outlier_factor().to_bits()
}

impl Default for RobotConfig {
    /// Rusty, with a slip of 0.02 and equal wheels.
    fn default() -> Self {
        Self {
            wheel_radius_m: 0.033,
            track_m: 0.16,
            body_radius_m: 0.11,
            ticks_per_rev: 4096,
            wheel_limit_rad_s: 20.0,
            slip_std: 0.02,
            slip_std_left: None,
            slip_std_right: None,
            slip_outlier_rate: 0.0,
            slip_outlier_factor: outlier_factor(),
            radius_bias_right: 0.0,
            track_bias: 0.0,
        }
    }
}

/// What the maker says of the robot: all an estimator is told.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NominalRobot {
    /// Wheels, track and encoders.
    pub drive: DiffDrive,
    /// Radius of the body's disc, m.
    pub body_radius_m: f64,
    /// Fastest a wheel can turn, rad/s.
    pub wheel_limit_rad_s: f64,
}

impl RobotConfig {
    /// What may be told of the robot: no slip, no biases.
    #[must_use]
    pub fn nominal(&self) -> NominalRobot {
        NominalRobot {
            drive: DiffDrive {
                wheel_radius_m: self.wheel_radius_m,
                track_m: self.track_m,
                ticks_per_rev: self.ticks_per_rev,
            },
            body_radius_m: self.body_radius_m,
            wheel_limit_rad_s: self.wheel_limit_rad_s,
        }
    }

    /// The law of the slip of each wheel, `[left, right]`.
    #[must_use]
    pub fn slip_figures(&self) -> [SlipFigures; 2] {
        [self.slip_std_left, self.slip_std_right].map(|std| SlipFigures {
            std: std.unwrap_or(self.slip_std),
            outlier_rate: self.slip_outlier_rate,
            outlier_factor: self.slip_outlier_factor,
        })
    }

    /// The same robot with wheels that do not slip.
    #[must_use]
    pub fn without_slip(self) -> Self {
        Self {
            slip_std: 0.0,
            slip_std_left: None,
            slip_std_right: None,
            slip_outlier_rate: 0.0,
            slip_outlier_factor: outlier_factor(),
            ..self
        }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// [`FieldError`] names the first that cannot be used.
    pub fn check(&self) -> Result<(), FieldError> {
        within("robot.wheel_radius_m", self.wheel_radius_m, 1e-4, 10.0)?;
        within("robot.track_m", self.track_m, 1e-3, 100.0)?;
        within("robot.body_radius_m", self.body_radius_m, 0.0, 100.0)?;
        super::at_least("robot.ticks_per_rev", self.ticks_per_rev, 1, 1 << 40)?;
        within("robot.wheel_limit_rad_s", self.wheel_limit_rad_s, 1e-3, 1e5)?;
        let figures = SlipFigures {
            std: self.slip_std,
            outlier_rate: self.slip_outlier_rate,
            outlier_factor: self.slip_outlier_factor,
        };
        figures.check("robot")?;
        within("robot.slip_std_left", self.slip_std_left.unwrap_or_default(), 0.0, 1.0)?;
        within("robot.slip_std_right", self.slip_std_right.unwrap_or_default(), 0.0, 1.0)?;
        within("robot.radius_bias_right", self.radius_bias_right, -0.5, 0.5)?;
        within("robot.track_bias", self.track_bias, -0.5, 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_is_checked() {
        assert!(RobotConfig::default().check().is_ok());
        let broken: [fn(&mut RobotConfig); 12] = [
            |r| r.wheel_radius_m = 0.0,
            |r| r.track_m = f64::NAN,
            |r| r.body_radius_m = -1.0,
            |r| r.ticks_per_rev = 0,
            |r| r.wheel_limit_rad_s = f64::INFINITY,
            |r| r.slip_std = -0.02,
            |r| r.slip_std_left = Some(-0.02),
            |r| r.slip_std_right = Some(f64::NAN),
            |r| r.slip_outlier_rate = 1.1,
            |r| r.slip_outlier_factor = 0.9,
            |r| r.radius_bias_right = 2.0,
            |r| r.track_bias = f64::NAN,
        ];
        for (i, break_it) in broken.iter().enumerate() {
            let mut robot = RobotConfig::default();
            break_it(&mut robot);
            assert!(robot.check().is_err(), "field {i}");
        }
    }

    #[test]
    fn a_robot_whose_track_is_as_it_is_said_is_written_as_ever() {
        let mut robot = RobotConfig::default();
        let text = serde_json::to_string(&robot).unwrap();
        assert!(
            !text.contains("track_bias") && !text.contains("_left") && !text.contains("outlier")
        );
        robot.track_bias = 0.01;
        robot.slip_std_left = Some(0.03);
        (robot.slip_outlier_rate, robot.slip_outlier_factor) = (0.01, 5.0);
        let text = serde_json::to_string(&robot).unwrap();
        assert_eq!(serde_json::from_str::<RobotConfig>(&text).unwrap(), robot);
        assert_eq!(robot.nominal(), RobotConfig::default().nominal());
    }
}
