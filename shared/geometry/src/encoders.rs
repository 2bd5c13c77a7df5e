//! Encoders: whole counts of each wheel, and the motion two readings bound.
//!
//! Source: the online *Probabilistic Robotics*, chapter 4, "Odometry: from
//! integer counts to a pose increment". One count is λ = 2πr/N metres of ground;
//! Δs_i = λ Δticks_i and the pose moves by (½(Δs_L + Δs_R), 0, (Δs_R − Δs_L)/ℓ).
//!
//! Departure: counts are 64 bits wide. At N = 2²⁶ a minute of driving already
//! passes 2³³.

use core::f64::consts::TAU;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::drive::DiffDrive;

/// The two wheels' counters since the start of a run; forward counts up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EncoderCounts {
    /// Counts of the left wheel.
    pub left: i64,
    /// Counts of the right wheel.
    pub right: i64,
}

impl EncoderCounts {
    /// The counters of wheels turned by `[left, right]` radians in all: the
    /// nearest whole count, halves away from zero.
    ///
    /// Reading the *total* angle is what keeps quantization from accumulating:
    /// the error of any difference of two readings stays within one count. An
    /// angle beyond the range of `i64` saturates; NaN reads 0.
    #[must_use]
    pub fn from_wheel_angles(wheel_angles_rad: [f64; 2], ticks_per_rev: u64) -> Self {
        let ticks_per_rad = ticks_per_rev as f64 / TAU;
        let [left, right] = wheel_angles_rad.map(|angle| (angle * ticks_per_rad).round() as i64);
        Self { left, right }
    }
}

/// λ = 2πr/N: metres of ground per count.
#[must_use]
pub fn tick_length(drive: &DiffDrive) -> f64 {
    TAU * drive.wheel_radius_m / drive.ticks_per_rev as f64
}

/// The tangent vector (Δs m, 0, Δθ rad) between two readings, to be applied as
/// `pose ⊞ delta`.
///
/// The counts are subtracted as integers, wrapping: no digit is lost however
/// long the run, and a counter that rolls over between two readings still gives
/// the right difference. The difference is exact as `f64` up to 2⁵³ counts.
#[must_use]
pub fn odometry_delta(prev: EncoderCounts, cur: EncoderCounts, drive: &DiffDrive) -> Vector3<f64> {
    let lambda_m = tick_length(drive);
    drive.tangent(
        lambda_m * cur.left.wrapping_sub(prev.left) as f64,
        lambda_m * cur.right.wrapping_sub(prev.right) as f64,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_trip_of_the_book() {
        let drive = DiffDrive::rusty();
        assert!((tick_length(&drive) - 5.0621e-5).abs() < 5e-10);
        assert!((0.72 / tick_length(&drive) - 14_223.24).abs() < 5e-3);
        let angles_rad = [0.72 / drive.wheel_radius_m, 0.88 / drive.wheel_radius_m];
        let ticks = EncoderCounts::from_wheel_angles(angles_rad, drive.ticks_per_rev);
        assert_eq!((ticks.left, ticks.right), (14_223, 17_384));
        let tau = odometry_delta(EncoderCounts::default(), ticks, &drive);
        assert!((tau.x - 0.799_994_76).abs() < 1e-8);
        assert_eq!(tau.y, 0.0);
        assert!((tau.z - 1.000_088_36).abs() < 1e-8);
    }

    #[test]
    fn halves_go_away_from_zero() {
        let half_rad = 0.5 * (TAU / 4.0);
        let ticks = EncoderCounts::from_wheel_angles([half_rad, -half_rad], 4);
        assert_eq!((ticks.left, ticks.right), (1, -1));
        let odd = EncoderCounts::from_wheel_angles([f64::NAN, f64::INFINITY], 4);
        assert_eq!((odd.left, odd.right), (0, i64::MAX));
    }

    #[test]
    fn a_counter_may_roll_over() {
        let drive = DiffDrive::rusty();
        let before = EncoderCounts { left: i64::MAX - 1, right: i64::MIN + 1 };
        let after = EncoderCounts { left: i64::MIN + 1, right: i64::MAX - 1 };
        let tau = odometry_delta(before, after, &drive);
        assert_eq!(tau, drive.tangent(3.0 * tick_length(&drive), -3.0 * tick_length(&drive)));
    }
}
