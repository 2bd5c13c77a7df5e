//! A fan of beams: the directions in which a scan looks.

use nalgebra::Vector2;

use crate::trig;

/// Beams spread evenly over an angle, in the sensor frame.
///
/// Beam k of n points along φ_k = `first_bearing_rad` + `fov_rad`·k/n, so that
/// over 2π beam n would be beam 0 again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fan {
    /// Bearing of beam 0, rad.
    pub first_bearing_rad: f64,
    /// Angle over which the beams are spread, rad.
    pub fov_rad: f64,
    /// Number of beams n.
    pub beams: u32,
}

impl Fan {
    /// Bearing φ_k of beam `k` in the sensor frame, rad.
    #[inline]
    #[must_use]
    pub fn bearing_rad(&self, k: u32) -> f64 {
        self.first_bearing_rad + self.fov_rad * f64::from(k) / f64::from(self.beams)
    }

    /// (cos φ_k, sin φ_k) of beam `k`, sensor frame.
    #[must_use]
    pub fn direction(&self, k: u32) -> Vector2<f64> {
        let (s, c) = trig::sin_cos(self.bearing_rad(k));
        Vector2::new(c, s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{PI, TAU};

    #[test]
    fn beams_are_spread_from_the_first_bearing() {
        let fan = Fan { first_bearing_rad: -PI, fov_rad: TAU, beams: 180 };
        assert_eq!(fan.bearing_rad(0), -PI);
        assert_eq!(fan.bearing_rad(90), 0.0);
        assert_eq!(fan.direction(90), Vector2::new(1.0, 0.0));
        let half = Fan { first_bearing_rad: 0.0, fov_rad: PI, beams: 2 };
        assert_eq!(half.bearing_rad(1), 0.5 * PI);
    }
}
