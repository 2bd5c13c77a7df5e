//! The differential drive: two wheel rates in, one twist out, and back.
//!
//! Source: the online *Probabilistic Robotics*, chapter 4, "From two wheels to
//! one twist"; Lynch and Park, *Modern Robotics* (2017), §13.3. With wheel radius
//! r and track ℓ: v = r/2 (ω_R + ω_L), ω = r/ℓ (ω_R − ω_L), and backwards
//! ω_L = (v − ω ℓ/2)/r, ω_R = (v + ω ℓ/2)/r. The body x axis points forward, y
//! to the left; the sideways speed is structurally zero.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// A body twist: forward speed and yaw rate (counter-clockwise positive).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Twist {
    /// Forward speed in metres per second; negative drives backwards.
    pub v_m_s: f64,
    /// Yaw rate in radians per second; positive turns left.
    pub omega_rad_s: f64,
}

/// The turning rates of the two wheels; positive rolls forward.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WheelRates {
    /// Left wheel, radians per second.
    pub left_rad_s: f64,
    /// Right wheel, radians per second.
    pub right_rad_s: f64,
}

/// The three numbers that make a differential drive. Lengths are positive and
/// finite and `ticks_per_rev` is not zero; nothing here checks that, the
/// configuration that carries a drive does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DiffDrive {
    /// Radius of both wheels, metres.
    pub wheel_radius_m: f64,
    /// Distance between the wheels' contact points, metres.
    pub track_m: f64,
    /// Encoder counts per revolution of a wheel.
    pub ticks_per_rev: u64,
}

impl DiffDrive {
    /// The robot of the book: r = 0.033 m, ℓ = 0.16 m, 4096 counts.
    #[must_use]
    pub fn rusty() -> Self {
        Self { wheel_radius_m: 0.033, track_m: 0.16, ticks_per_rev: 4096 }
    }

    /// The wheel rates that drive `twist`.
    #[must_use]
    pub fn wheel_rates(&self, twist: Twist) -> WheelRates {
        let half_m_s = twist.omega_rad_s * self.track_m / 2.0;
        WheelRates {
            left_rad_s: (twist.v_m_s - half_m_s) / self.wheel_radius_m,
            right_rad_s: (twist.v_m_s + half_m_s) / self.wheel_radius_m,
        }
    }

    /// The twist that `rates` drive: the inverse of [`DiffDrive::wheel_rates`]
    /// up to rounding.
    #[must_use]
    pub fn twist(&self, rates: WheelRates) -> Twist {
        let left_m_s = self.wheel_radius_m * rates.left_rad_s;
        let right_m_s = self.wheel_radius_m * rates.right_rad_s;
        Twist {
            v_m_s: 0.5 * (right_m_s + left_m_s),
            omega_rad_s: (right_m_s - left_m_s) / self.track_m,
        }
    }

    /// The tangent vector (Δs m, 0, Δθ rad) of a motion in which the wheels laid
    /// down `ds_left_m` and `ds_right_m` metres of ground at a constant ratio.
    #[must_use]
    pub fn tangent(&self, ds_left_m: f64, ds_right_m: f64) -> Vector3<f64> {
        Vector3::new(0.5 * (ds_right_m + ds_left_m), 0.0, (ds_right_m - ds_left_m) / self.track_m)
    }

    /// Signed distance in metres from the robot's centre along its y axis to the
    /// instantaneous centre of rotation, v/ω; `None` when the twist does not
    /// turn. Zero is a spin in place, positive a turn to the left going forward.
    #[must_use]
    pub fn turn_radius_m(&self, twist: Twist) -> Option<f64> {
        if twist.omega_rad_s == 0.0 {
            return None;
        }
        Some(twist.v_m_s / twist.omega_rad_s)
    }

    /// `twist` slowed down, v and ω by one factor so that the path keeps its
    /// curvature, until neither wheel turns faster than `wheel_limit_rad_s`.
    ///
    /// A twist within the limit comes back with its exact bits. The limit holds
    /// exactly, not up to rounding: `wheel_rates` of the result never exceeds
    /// it. A twist whose wheel rates are not finite, or a limit that is NaN or
    /// negative, gives the twist that stands still, because a command no client
    /// understands must not move a robot. An infinite limit limits nothing.
    #[must_use]
    pub fn limit(&self, twist: Twist, wheel_limit_rad_s: f64) -> Twist {
        let peak_rad_s = self.peak_rate(twist);
        // Written so that a NaN on either side stands still, too.
        if !(peak_rad_s.is_finite() && wheel_limit_rad_s >= 0.0) {
            return Twist::default();
        }
        if peak_rad_s <= wheel_limit_rad_s {
            return twist;
        }
        let factor = wheel_limit_rad_s / peak_rad_s;
        let slowed = scaled(twist, factor);
        if self.peak_rate(slowed) <= wheel_limit_rad_s {
            return slowed;
        }
        // The faster wheel adds two magnitudes, so fewer than eight roundings of
        // half a unit in the last place separate it from the exact product.
        scaled(twist, factor * (1.0 - 8.0 * f64::EPSILON))
    }

    /// The tightest turn at speed `v_m_s` (either sign) for wheels that turn at
    /// most `wheel_limit_rad_s`: `(omega_rad_s, radius_m)`, both non-negative,
    /// with the outer wheel at its limit. `None` when the speed leaves the outer
    /// wheel nothing to turn with.
    #[must_use]
    pub fn tightest_turn(&self, v_m_s: f64, wheel_limit_rad_s: f64) -> Option<(f64, f64)> {
        let spare_m_s = wheel_limit_rad_s * self.wheel_radius_m - v_m_s.abs();
        let omega_rad_s = 2.0 * spare_m_s / self.track_m;
        if omega_rad_s > 0.0 { Some((omega_rad_s, v_m_s.abs() / omega_rad_s)) } else { None }
    }

    /// The larger of the two wheels' absolute rates; NaN if either is NaN.
    fn peak_rate(&self, twist: Twist) -> f64 {
        let rates = self.wheel_rates(twist);
        let (left, right) = (rates.left_rad_s.abs(), rates.right_rad_s.abs());
        // `f64::max` would hide a NaN.
        if left > right || left.is_nan() { left } else { right }
    }
}

/// Both parts of `twist` times `factor`.
fn scaled(twist: Twist, factor: f64) -> Twist {
    Twist { v_m_s: twist.v_m_s * factor, omega_rad_s: twist.omega_rad_s * factor }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn twist(v_m_s: f64, omega_rad_s: f64) -> Twist {
        Twist { v_m_s, omega_rad_s }
    }

    #[test]
    fn three_ways_to_turn() {
        let drive = DiffDrive::rusty();
        let straight = drive.wheel_rates(twist(0.33, 0.0));
        assert_eq!(straight.left_rad_s, straight.right_rad_s);
        assert_eq!(drive.turn_radius_m(twist(0.33, 0.0)), None);
        let spin = drive.wheel_rates(twist(0.0, 1.0));
        assert_eq!(spin.left_rad_s, -spin.right_rad_s);
        assert_eq!(drive.turn_radius_m(twist(0.0, 1.0)), Some(0.0));
        let about_a_wheel = drive.wheel_rates(twist(0.08, 1.0));
        assert_eq!(about_a_wheel.left_rad_s, 0.0);
        assert_eq!(drive.turn_radius_m(twist(0.08, 1.0)), Some(0.08));
    }

    #[test]
    fn worked_example_of_the_tangent() {
        let tau = DiffDrive::rusty().tangent(0.72, 0.88);
        assert!((tau.x - 0.80).abs() < 1e-15);
        assert_eq!(tau.y, 0.0);
        assert!((tau.z - 1.00).abs() < 1e-15);
    }

    #[test]
    fn tightest_turn_of_the_book() {
        let drive = DiffDrive::rusty();
        let (omega_rad_s, radius_m) = drive.tightest_turn(0.4, 20.0).unwrap();
        assert!((omega_rad_s - 3.25).abs() < 1e-12);
        assert!((radius_m - 0.123_077).abs() < 5e-7);
        assert_eq!(drive.tightest_turn(-0.4, 20.0), drive.tightest_turn(0.4, 20.0));
        assert_eq!(drive.tightest_turn(0.0, 20.0).unwrap().1, 0.0);
        assert_eq!(drive.tightest_turn(0.67, 20.0), None);
        assert_eq!(drive.tightest_turn(f64::NAN, 20.0), None);
    }

    #[test]
    fn limits_that_make_no_sense_stand_still() {
        let drive = DiffDrive::rusty();
        for bad in [f64::NAN, -1.0, f64::NEG_INFINITY] {
            assert_eq!(drive.limit(twist(1.0, 1.0), bad), Twist::default());
        }
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(drive.limit(twist(bad, 0.1), 20.0), Twist::default());
            assert_eq!(drive.limit(twist(0.1, bad), 20.0), Twist::default());
        }
        assert_eq!(drive.limit(twist(1.0, 1.0), 0.0), Twist::default());
        assert_eq!(drive.limit(twist(9.0, 1.0), f64::INFINITY), twist(9.0, 1.0));
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn rates_and_twist_are_inverse(v in -2.0_f64..2.0, omega in -20.0_f64..20.0) {
            let drive = DiffDrive::rusty();
            let back = drive.twist(drive.wheel_rates(twist(v, omega)));
            prop_assert!((back.v_m_s - v).abs() < 1e-12);
            prop_assert!((back.omega_rad_s - omega).abs() < 1e-12);
        }

        #[test]
        fn limit_holds_exactly_and_keeps_the_curvature(
            v in -5.0_f64..5.0, omega in -50.0_f64..50.0, wheel_limit in 0.1_f64..60.0,
        ) {
            let drive = DiffDrive::rusty();
            let wanted = twist(v, omega);
            let given = drive.limit(wanted, wheel_limit);
            let rates = drive.wheel_rates(given);
            prop_assert!(rates.left_rad_s.abs() <= wheel_limit);
            prop_assert!(rates.right_rad_s.abs() <= wheel_limit);
            prop_assert!((given.v_m_s * omega - given.omega_rad_s * v).abs() < 1e-12);
            let before = drive.wheel_rates(wanted);
            if before.left_rad_s.abs().max(before.right_rad_s.abs()) <= wheel_limit {
                prop_assert_eq!(given, wanted);
            } else {
                let peak = rates.left_rad_s.abs().max(rates.right_rad_s.abs());
                prop_assert!(peak > wheel_limit * (1.0 - 1e-14));
            }
        }
    }
}
