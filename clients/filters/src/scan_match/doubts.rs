//! Motions that are less sure than they say: wheels that slipped or are lost, and a match
//! that another pose contradicts.

use rusty_geometry::{SE2, trig};

use crate::Motion;
use crate::tangent::independent;

/// How far off a motion may be by wheels that slipped, or by a laser that is not
/// quite where it is said to be, one deviation: m at least, m per rad of turn, m
/// per m of way.
const SLIPS_M: [f64; 3] = [0.005, 0.15, 0.01];
/// The same for the heading: rad at least, rad per rad, rad per m.
const SLIPS_RAD: [f64; 3] = [0.03, 0.1, 0.05];
/// Deviations of wheels that are lost, and of a motion that no match says.
const LOST_M: f64 = 0.25;
const LOST_RAD: f64 = 0.25;

/// The motion by wheels that may have slipped.
pub(super) fn slipped(wheels: &Motion) -> Motion {
    let moved = &wheels.now_in_then;
    let (turn_rad, way_m) = (moved.theta().abs(), trig::hypot(moved.x(), moved.y()));
    let of = |[least, per_rad, per_m]: [f64; 3]| least + per_rad * turn_rad + per_m * way_m;
    let covariance = wheels.covariance + independent(of(SLIPS_M), of(SLIPS_RAD));
    Motion { covariance, ..*wheels }
}

/// The motion by wheels that are lost.
pub(super) fn lost(wheels: &Motion) -> Motion {
    Motion { covariance: wheels.covariance + independent(LOST_M, LOST_RAD), ..*wheels }
}

/// A motion to about a pose, as unsure as half of the way to another one that may be right.
pub(super) fn doubted(motion: &Motion, pose: &SE2, other: &SE2) -> Motion {
    let half = 0.5 * other.boxminus(pose);
    Motion { covariance: motion.covariance + half * half.transpose(), ..*motion }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};

    use super::*;

    #[test]
    fn a_motion_is_as_unsure_as_half_of_the_way_to_another_pose() {
        let covariance = Matrix3::from_diagonal(&Vector3::new(0.04, 0.01, 0.01));
        let motion = Motion { now_in_then: SE2::new(1.0, 0.0, 0.0), covariance };
        let doubted = doubted(&motion, &motion.now_in_then, &SE2::new(1.0, 0.6, 0.0));
        assert_eq!(doubted.now_in_then, motion.now_in_then);
        let expected = Matrix3::from_diagonal(&Vector3::new(0.04, 0.1, 0.01));
        assert!((doubted.covariance - expected).norm() < 1e-12, "{}", doubted.covariance);
    }
}
