//! The bumper: which sectors of the body touch something.

use serde::{Deserialize, Serialize};

use crate::config::{FieldError, at_least, within};

/// Contact sectors around the body. Sector k of n spans the bearings from
/// `first_bearing_rad` + `fov_rad`·k/n to `first_bearing_rad` + `fov_rad`·(k + 1)/n
/// in the body frame. It has a reading in every tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BumperConfig {
    /// Number of sectors n, 1 to 16.
    pub sectors: u32,
    /// Where sector 0 begins, body frame, rad.
    pub first_bearing_rad: f64,
    /// Angle over which the sectors are spread, rad.
    pub fov_rad: f64,
}

impl Default for BumperConfig {
    /// Five sectors over the front half, sector 2 straight ahead: the number that
    /// the bumper of an iRobot Create 3 has.
    fn default() -> Self {
        let first_bearing_rad = -std::f64::consts::FRAC_PI_2;
        Self { sectors: 5, first_bearing_rad, fov_rad: std::f64::consts::PI }
    }
}

impl BumperConfig {
    /// Checks every field.
    ///
    /// # Errors
    /// [`FieldError`] names the first that cannot be used.
    pub fn check(&self) -> Result<(), FieldError> {
        let turn = std::f64::consts::TAU;
        at_least("sensors.bumper.sectors", self.sectors.into(), 1, 16)?;
        within("sensors.bumper.first_bearing_rad", self.first_bearing_rad, -turn, turn)?;
        within("sensors.bumper.fov_rad", self.fov_rad, 1e-6, turn + 1e-9)
    }
}
