//! Which estimates are wrong: far off, and without a warning.
//!
//! An estimator that does not know where it is should say so, by a wide covariance or
//! by none at all. That is not the NEES, which is also large where 2 mm are said and 1 cm
//! is meant: a robot that trusts a wrong estimate goes elsewhere.

use nalgebra::{Matrix2, Vector2};
use rusty_contract::Estimate;
use rusty_geometry::SE2;

/// The least position error of a wrong estimate, m: half a door's width.
const LEAST_M: f64 = 0.5;
/// Standard deviations that cover an error.
const COVERED: f64 = 4.0;

/// Whether an estimate whose position is off by `error_m` is wrong. A covariance that has
/// no inverse covers nothing.
pub(crate) fn is_wrong(error_m: f64, truth: &SE2, estimate: &Estimate) -> bool {
    let covers = |covariance: &[f64; 9]| {
        let tau = truth.boxminus(&estimate.pose_in_world);
        let [xx, xy, _, yx, yy, ..] = *covariance;
        let position_m = Vector2::new(tau.x, tau.y);
        let inverse = Matrix2::new(xx, xy, yx, yy).try_inverse();
        let squared = inverse.map(|inverse| position_m.dot(&(inverse * position_m)));
        squared.is_some_and(|squared| (0.0..=COVERED * COVERED).contains(&squared))
    };
    error_m > LEAST_M && !estimate.covariance.as_ref().is_some_and(covers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_off_and_not_covered() {
        let truth = SE2::new(1.0, 2.0, 1.5);
        let with = |x_m: f64, std_m: Option<f64>| Estimate {
            covariance: std_m.map(|s| [s * s, 0.0, 0.0, 0.0, s * s, 0.0, 0.0, 0.0, 1.0]),
            ..Estimate::from(SE2::new(x_m, 2.0, 1.5))
        };
        for (x_m, std_m, expected) in [
            (1.49, None, false),
            (1.51, None, true),
            (1.51, Some(0.13), false),
            (1.51, Some(0.12), true),
            (1.49, Some(1e-3), false),
            (9.0, Some(3.0), false),
            (9.0, Some(0.0), true),
            (9.0, Some(f64::NAN), true),
        ] {
            let found = is_wrong(x_m - 1.0, &truth, &with(x_m, std_m));
            assert_eq!(found, expected, "{x_m} {std_m:?}");
        }
    }
}
