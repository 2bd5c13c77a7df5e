//! The door detector.

use serde::{Deserialize, Serialize};

use crate::config::{FieldError, at_least, within};

/// A detector that reports doors by their numbers: a door that is in view with the
/// hit rate, any other door of the world with the rate of false alarms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DoorSensorConfig {
    /// A door is in view up to this distance of its middle, m.
    pub range_max_m: f64,
    /// Angle of view, half of it to each side of straight ahead, rad.
    pub fov_rad: f64,
    /// Probability that a door in view is reported.
    pub hit_rate: f64,
    /// Probability that a door that is not in view is reported.
    pub false_alarm_rate: f64,
    /// A reading in one of N ticks, the first in tick 0.
    pub every: u64,
}

impl Default for DoorSensorConfig {
    /// 2 m all round; the rates 0.6 and 0.2 of the door sensor in *Probabilistic
    /// Robotics*, section 2.4.2.
    fn default() -> Self {
        let fov_rad = std::f64::consts::TAU;
        Self { range_max_m: 2.0, fov_rad, hit_rate: 0.6, false_alarm_rate: 0.2, every: 5 }
    }
}

impl DoorSensorConfig {
    /// Checks every field.
    ///
    /// # Errors
    /// [`FieldError`] names the first that cannot be used.
    pub fn check(&self) -> Result<(), FieldError> {
        within("sensors.doors.range_max_m", self.range_max_m, 1e-3, 1e4)?;
        within("sensors.doors.fov_rad", self.fov_rad, 1e-3, std::f64::consts::TAU + 1e-9)?;
        within("sensors.doors.hit_rate", self.hit_rate, 0.0, 1.0)?;
        within("sensors.doors.false_alarm_rate", self.false_alarm_rate, 0.0, 1.0)?;
        at_least("sensors.doors.every", self.every, 1, 1 << 40)
    }
}
