//! The sensor that measures range and bearing to landmarks.

use serde::{Deserialize, Serialize};

use crate::config::{FieldError, at_least, within};

/// Whether a reading says which landmark it is of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Identity {
    /// It does: known correspondences.
    #[default]
    Given,
    /// It does not; readings then come in the order of their bearings.
    Hidden,
}

/// A sensor that measures range and bearing to every landmark of the world that
/// is in view and not behind a wall, at most the 64 nearest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LandmarkSensorConfig {
    /// How far it sees, m.
    pub range_max_m: f64,
    /// Angle of view, half of it to each side of straight ahead, rad.
    pub fov_rad: f64,
    /// Standard deviation of a range, m.
    pub range_std_m: f64,
    /// Standard deviation of a bearing, rad.
    pub bearing_std_rad: f64,
    /// Probability that a landmark in view is not seen.
    pub dropout: f64,
    /// Whether a reading says which landmark it is of.
    pub identity: Identity,
    /// A reading in one of N ticks, the first in tick 0.
    pub every: u64,
}

impl Default for LandmarkSensorConfig {
    /// 5 m all round, 5 cm and 2°, identity given.
    fn default() -> Self {
        Self {
            range_max_m: 5.0,
            fov_rad: std::f64::consts::TAU,
            range_std_m: 0.05,
            bearing_std_rad: 0.035,
            dropout: 0.0,
            identity: Identity::Given,
            every: 5,
        }
    }
}

impl LandmarkSensorConfig {
    /// Checks every field.
    ///
    /// # Errors
    /// [`FieldError`] names the first that cannot be used.
    pub fn check(&self) -> Result<(), FieldError> {
        let turn = std::f64::consts::TAU;
        within("sensors.landmarks.range_max_m", self.range_max_m, 1e-3, 1e4)?;
        within("sensors.landmarks.fov_rad", self.fov_rad, 1e-3, turn + 1e-9)?;
        within("sensors.landmarks.range_std_m", self.range_std_m, 0.0, 1e3)?;
        within("sensors.landmarks.bearing_std_rad", self.bearing_std_rad, 0.0, turn)?;
        within("sensors.landmarks.dropout", self.dropout, 0.0, 1.0)?;
        at_least("sensors.landmarks.every", self.every, 1, 1 << 40)
    }
}
