//! The LiDAR: geometry of its beams, and the noise its data sheet states.

use std::f64::consts::FRAC_PI_2;

use rusty_geometry::{Fan, SE2};
use serde::{Deserialize, Serialize};

use super::{FieldError, at_least, within};
use crate::frame::MAX_BEAMS;

/// A planar ray-cast LiDAR. Beam k of n points along
/// φ_k = `first_bearing_rad` + `fov_rad`·k/n in the sensor frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LidarConfig {
    /// Number of beams n, 1 to 1080.
    pub beams: u32,
    /// Bearing of beam 0 in the sensor frame, rad.
    pub first_bearing_rad: f64,
    /// Angle over which the n beams are spread, rad; beam n would be beam 0
    /// again at 2π.
    pub fov_rad: f64,
    /// Range z_max a beam reports when nothing came back, m.
    pub range_max_m: f64,
    /// Standard deviation σ_0 of a range at distance 0, m.
    pub range_std_m: f64,
    /// Growth κ of the standard deviation with the range, m per m: a range r has
    /// σ_r² = σ_0² + (κ·r)².
    #[serde(skip_serializing_if = "is_zero")]
    pub range_std_per_m: f64,
    /// Probability that a beam returns nothing.
    pub dropout: f64,
    /// Greatest angle of incidence at which every pane of glass returns every beam,
    /// rad; π/2: at all angles. Farther from the perpendicular a beam may pass.
    #[serde(skip_serializing_if = "is_right_angle")]
    pub glass_visible_rad: f64,
    /// Full angle of the footprint of a beam, rad. Where it covers an edge, the range
    /// is between both surfaces (a mixed pixel).
    #[serde(skip_serializing_if = "is_zero")]
    pub divergence_rad: f64,
    /// Pose of the sensor on the body.
    pub sensor_in_body: SE2,
}

impl Default for LidarConfig {
    /// Rusty's: 180 beams over the full circle, beam 90 straight ahead, 8 m,
    /// 2 cm, no dropout, glass like walls, thin beams, mounted at the centre.
    fn default() -> Self {
        Self {
            beams: 180,
            first_bearing_rad: -std::f64::consts::PI,
            fov_rad: std::f64::consts::TAU,
            range_max_m: 8.0,
            range_std_m: 0.02,
            range_std_per_m: 0.0,
            dropout: 0.0,
            glass_visible_rad: FRAC_PI_2,
            divergence_rad: 0.0,
            sensor_in_body: SE2::identity(),
        }
    }
}

fn is_zero(x: &f64) -> bool {
    x.to_bits() == 0
}

fn is_right_angle(x: &f64) -> bool {
    *x == FRAC_PI_2
}

impl LidarConfig {
    /// Bearing φ_k of beam `k` in the sensor frame, rad.
    #[must_use]
    pub fn bearing_rad(&self, k: u32) -> f64 {
        self.fan().bearing_rad(k)
    }

    /// The beams.
    #[must_use]
    pub fn fan(&self) -> Fan {
        let Self { first_bearing_rad, fov_rad, beams, .. } = *self;
        Fan { first_bearing_rad, fov_rad, beams }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// [`FieldError`] names the first that cannot be used.
    pub fn check(&self) -> Result<(), FieldError> {
        at_least("lidar.beams", u64::from(self.beams), 1, MAX_BEAMS as u64)?;
        let pi = std::f64::consts::PI;
        within("lidar.first_bearing_rad", self.first_bearing_rad, -2.0 * pi, 2.0 * pi)?;
        within("lidar.fov_rad", self.fov_rad, 1e-6, 2.0 * pi + 1e-9)?;
        within("lidar.range_max_m", self.range_max_m, 1e-3, 1e4)?;
        within("lidar.range_std_m", self.range_std_m, 0.0, 1e3)?;
        within("lidar.range_std_per_m", self.range_std_per_m, 0.0, 1.0)?;
        within("lidar.dropout", self.dropout, 0.0, 1.0)?;
        within("lidar.glass_visible_rad", self.glass_visible_rad, 0.0, FRAC_PI_2)?;
        within("lidar.divergence_rad", self.divergence_rad, 0.0, 0.2)?;
        let s = self.sensor_in_body;
        within("lidar.sensor_in_body.x_m", s.x(), -100.0, 100.0)?;
        within("lidar.sensor_in_body.y_m", s.y(), -100.0, 100.0)?;
        within("lidar.sensor_in_body.theta_rad", s.theta(), -pi, pi)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beam_90_of_180_points_straight_ahead() {
        assert_eq!(LidarConfig::default().bearing_rad(90), 0.0);
        assert_eq!(LidarConfig::default().bearing_rad(0), -std::f64::consts::PI);
    }

    #[test]
    fn what_is_off_is_not_written_and_what_is_on_comes_back() {
        let text = serde_json::to_string(&LidarConfig::default()).unwrap();
        for field in ["range_std_per_m", "glass_visible_rad", "divergence_rad"] {
            assert!(!text.contains(field), "{text}");
        }
        assert_eq!(serde_json::from_str::<LidarConfig>(&text).unwrap(), LidarConfig::default());
        let (range_std_per_m, glass_visible_rad, divergence_rad) = (0.01, 0.3, 0.008);
        let on = LidarConfig {
            range_std_per_m,
            glass_visible_rad,
            divergence_rad,
            ..LidarConfig::default()
        };
        let text = serde_json::to_string(&on).unwrap();
        assert_eq!(serde_json::from_str::<LidarConfig>(&text).unwrap(), on);
    }

    #[test]
    fn every_field_is_checked() {
        assert!(LidarConfig::default().check().is_ok());
        let broken: [fn(&mut LidarConfig); 10] = [
            |l| l.beams = 0,
            |l| l.beams = 1081,
            |l| l.first_bearing_rad = f64::NAN,
            |l| l.fov_rad = 7.0,
            |l| l.range_max_m = -8.0,
            |l| l.range_std_m = -0.1,
            |l| l.dropout = 1.5,
            |l| l.range_std_per_m = -0.01,
            |l| l.glass_visible_rad = 1.6,
            |l| l.divergence_rad = 0.21,
        ];
        for (i, break_it) in broken.iter().enumerate() {
            let mut lidar = LidarConfig::default();
            break_it(&mut lidar);
            assert!(lidar.check().is_err(), "field {i}");
        }
    }
}
