//! The small sensors: those that a robot may have next to its LiDAR.

mod bumper;
mod doors;
mod imu;
mod landmarks;
mod sonar;

use serde::{Deserialize, Serialize};

pub use bumper::BumperConfig;
pub use doors::DoorSensorConfig;
pub use imu::ImuConfig;
pub use landmarks::{Identity, LandmarkSensorConfig};
pub use sonar::{SonarConfig, SonarModel};

use super::FieldError;

/// The small sensors of a robot. One that is not configured is not there: it has
/// no readings, costs nothing, and its noise is not drawn.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sensors {
    /// Contact sectors of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bumper: Option<BumperConfig>,
    /// Yaw rate and acceleration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub imu: Option<ImuConfig>,
    /// Ultrasonic range sensors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sonar: Option<SonarConfig>,
    /// Detector of doors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub doors: Option<DoorSensorConfig>,
    /// Range and bearing to the landmarks of the world.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub landmarks: Option<LandmarkSensorConfig>,
}

impl Sensors {
    /// Whether the robot has no small sensor.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Checks every field.
    ///
    /// # Errors
    /// [`FieldError`] names the first that cannot be used.
    pub fn check(&self) -> Result<(), FieldError> {
        self.bumper.as_ref().map_or(Ok(()), BumperConfig::check)?;
        self.imu.as_ref().map_or(Ok(()), ImuConfig::check)?;
        self.sonar.as_ref().map_or(Ok(()), SonarConfig::check)?;
        self.doors.as_ref().map_or(Ok(()), DoorSensorConfig::check)?;
        self.landmarks.as_ref().map_or(Ok(()), LandmarkSensorConfig::check)
    }
}

#[cfg(test)]
mod tests;
