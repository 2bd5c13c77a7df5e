//! Sonars: where they are mounted, and how they hear.

use rusty_geometry::SE2;
use serde::{Deserialize, Serialize};

use crate::config::{FieldError, at_least, within};
use crate::readings::MAX_SONARS;

/// Which wall a sonar hears.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SonarModel {
    /// The nearest point of any wall within the cone.
    #[default]
    Nearest,
    /// A wall only where the foot of the perpendicular lies on it and in the cone;
    /// a corner that faces the sensor, too.
    Specular,
}

/// Ultrasonic range sensors of one kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SonarConfig {
    /// Pose of each sonar on the body; x of the pose is the axis of its cone. 1 to
    /// 16 of them.
    pub mounts: Vec<SE2>,
    /// Full angle of the cone, rad.
    pub aperture_rad: f64,
    /// Range that is reported when nothing answers, m.
    pub range_max_m: f64,
    /// Standard deviation of a range, m.
    pub range_std_m: f64,
    /// Probability that an echo is not heard.
    pub dropout: f64,
    /// Which wall answers.
    pub model: SonarModel,
    /// A reading in one of N ticks, the first in tick 0.
    pub every: u64,
}

impl Default for SonarConfig {
    /// One Polaroid 6500 that looks ahead: a cone of 30° (first null of the beam at
    /// ±15°), 10.7 m, 1 cm.
    fn default() -> Self {
        Self {
            mounts: vec![SE2::new(0.1, 0.0, 0.0)],
            aperture_rad: std::f64::consts::FRAC_PI_6,
            range_max_m: 10.7,
            range_std_m: 0.01,
            dropout: 0.0,
            model: SonarModel::Nearest,
            every: 5,
        }
    }
}

impl SonarConfig {
    /// Checks every field.
    ///
    /// # Errors
    /// [`FieldError`] names the first that cannot be used.
    pub fn check(&self) -> Result<(), FieldError> {
        let pi = std::f64::consts::PI;
        let count = self.mounts.len() as u64;
        at_least("sensors.sonar.mounts (number of)", count, 1, MAX_SONARS as u64)?;
        for (k, mount) in self.mounts.iter().enumerate() {
            let field = |name: &str| format!("sensors.sonar.mounts[{k}].{name}");
            within(&field("x_m"), mount.x(), -100.0, 100.0)?;
            within(&field("y_m"), mount.y(), -100.0, 100.0)?;
            within(&field("theta_rad"), mount.theta(), -pi, pi)?;
        }
        within("sensors.sonar.aperture_rad", self.aperture_rad, 1e-3, pi)?;
        within("sensors.sonar.range_max_m", self.range_max_m, 1e-3, 1e4)?;
        within("sensors.sonar.range_std_m", self.range_std_m, 0.0, 1e3)?;
        within("sensors.sonar.dropout", self.dropout, 0.0, 1.0)?;
        at_least("sensors.sonar.every", self.every, 1, 1 << 40)
    }
}
