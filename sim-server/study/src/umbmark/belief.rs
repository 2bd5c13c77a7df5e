//! What a robot believes of its wheels, and what it does with it.

use rusty_geometry::{DiffDrive, EncoderCounts, SE2, Twist, WheelRates};
use serde::Serialize;

use super::factors::Factors;

/// Wheels and track as the robot believes them to be: one radius for each wheel,
/// so that a calibration has a place to go.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Belief {
    /// Radius of the left wheel, m.
    pub left_radius_m: f64,
    /// Radius of the right wheel, m.
    pub right_radius_m: f64,
    /// Distance between the wheels' contact points, m.
    pub track_m: f64,
    /// The drive as its maker describes it.
    #[serde(skip)]
    nominal: DiffDrive,
}

impl Belief {
    /// Before any calibration.
    #[must_use]
    pub fn nominal(drive: DiffDrive) -> Self {
        Self {
            left_radius_m: drive.wheel_radius_m,
            right_radius_m: drive.wheel_radius_m,
            track_m: drive.track_m,
            nominal: drive,
        }
    }

    /// With the factors of a calibration applied. The mean of the two radii
    /// stays: D_L = 2/(E_d + 1) · D_a and D_R = 2/(1/E_d + 1) · D_a.
    #[must_use]
    pub fn corrected(&self, factors: &Factors) -> Self {
        let [left, right] = factors.wheels();
        Self {
            left_radius_m: self.left_radius_m * left,
            right_radius_m: self.right_radius_m * right,
            track_m: self.track_m * factors.wheelbase,
            nominal: self.nominal,
        }
    }

    /// Where one believes to be after two readings of the encoders.
    #[must_use]
    pub fn advance(&self, pose: &SE2, before: EncoderCounts, now: EncoderCounts) -> SE2 {
        let rad_per_count = core::f64::consts::TAU / self.nominal.ticks_per_rev as f64;
        let turned = |from: i64, to: i64| rad_per_count * to.wrapping_sub(from) as f64;
        let drive = DiffDrive { track_m: self.track_m, ..self.nominal };
        pose.boxplus(&drive.tangent(
            self.left_radius_m * turned(before.left, now.left),
            self.right_radius_m * turned(before.right, now.right),
        ))
    }

    /// The command that makes the wheels turn as this belief wants them to for
    /// `wanted`: the robot's controller knows the nominal drive alone.
    #[must_use]
    pub fn command(&self, wanted: Twist) -> Twist {
        let half_m_s = 0.5 * wanted.omega_rad_s * self.track_m;
        self.nominal.twist(WheelRates {
            left_rad_s: (wanted.v_m_s - half_m_s) / self.left_radius_m,
            right_rad_s: (wanted.v_m_s + half_m_s) / self.right_radius_m,
        })
    }

    /// Metres of ground per encoder count, by the larger wheel.
    #[must_use]
    pub fn count_m(&self) -> f64 {
        let radius_m = self.left_radius_m.max(self.right_radius_m);
        core::f64::consts::TAU * radius_m / self.nominal.ticks_per_rev as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nominal_belief_is_the_drive() {
        let drive = DiffDrive::rusty();
        let belief = Belief::nominal(drive);
        let twist = Twist { v_m_s: 0.4, omega_rad_s: -0.7 };
        let command = belief.command(twist);
        assert!((command.v_m_s - 0.4).abs() < 1e-15 && (command.omega_rad_s + 0.7).abs() < 1e-14);
        let now = EncoderCounts { left: 14_223, right: 17_384 };
        let found = belief.advance(&SE2::identity(), EncoderCounts::default(), now);
        let expected = SE2::identity().boxplus(&rusty_geometry::odometry_delta(
            EncoderCounts::default(),
            now,
            &drive,
        ));
        assert!(found.boxminus(&expected).norm() < 1e-15);
    }

    #[test]
    fn a_correction_keeps_the_mean_wheel() {
        let belief = Belief::nominal(DiffDrive::rusty());
        let after = belief.corrected(&Factors { wheelbase: 1.01, diameters: 1.005 });
        assert!((after.left_radius_m + after.right_radius_m - 0.066).abs() < 1e-15);
        assert!((after.right_radius_m / after.left_radius_m - 1.005).abs() < 1e-14);
        assert_eq!(after.track_m, 0.16 * 1.01);
        // Wheels that it turns carry the robot as it wants, if it is right.
        let rates =
            DiffDrive::rusty().wheel_rates(after.command(Twist { v_m_s: 0.3, omega_rad_s: 0.5 }));
        let (left, right) =
            (rates.left_rad_s * after.left_radius_m, rates.right_rad_s * after.right_radius_m);
        assert!((0.5 * (left + right) - 0.3).abs() < 1e-15);
        assert!(((right - left) / after.track_m - 0.5).abs() < 1e-14);
    }
}
