//! Constant errors of the wheels, as a part of the state.
//!
//! A wheel that is 3 % too large turns a robot by 190 mrad in every metre, always to the
//! same side, and independent errors of ticks do not predict that. The state then gets
//! three more numbers: the scale of ways a, ds → (1 + a) ds; the scale of turns b and the
//! turn per metre c, dθ → (1 + b) dθ + c ds. [`crate::calibration`] derives them from the
//! radii and the base of the wheels.
//!
//! Source: A. Martinelli et al., *Simultaneous localization and odometry self calibration
//! for mobile robot*, Autonomous Robots 22 (2007), whose state has the pose and the
//! constant errors. They enter the state when the innovations show that they are needed,
//! as in the variable state dimension filter of Y. Bar-Shalom, K. Birmiwal (IEEE Trans.
//! Aerospace and Electronic Systems 18, 1982).
//!
//! Departures, and why:
//! * Errors of more than five of the deviations that they had at first are no constant errors
//!   of wheels, and all are unknown again: a robot that is held looks as if its wheels were tiny.
//! * The joint covariance is kept as blocks of 3 × 3, so that the block of the pose is computed
//!   as without them. Products of matrices of 6 × 6 would also depend on the instructions of the
//!   processor.

use nalgebra::{Matrix3, Vector3};
use rusty_geometry::SE2;

use crate::line_map::LineInnovation;
use crate::tangent::{right_jacobian, symmetric};

/// Deviations of a, b and c before anything was learned; c in rad/m. A wheel that is 3 %
/// too large on a base of 0.16 m has c = 0.19 rad/m.
const UNKNOWN: [f64; 3] = [0.03, 0.05, 0.2];

/// An error of more than this many of them is not one of the wheels.
const MOST_DEVIATIONS: f64 = 5.0;

/// a, b and c with their covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct WheelErrors {
    /// a, b, c (rad/m).
    pub errors: Vector3<f64>,
    /// Covariance of the errors.
    pub covariance: Matrix3<f64>,
    /// Covariance of the pose (rows) and the errors (columns).
    cross: Matrix3<f64>,
}

impl WheelErrors {
    /// Unknown errors.
    pub fn unknown() -> Self {
        let unknown = Vector3::from(UNKNOWN);
        Self {
            errors: Vector3::zeros(),
            covariance: Matrix3::from_diagonal(&unknown.component_mul(&unknown)),
            cross: Matrix3::zeros(),
        }
    }

    /// The twist of a tick's arc by these wheels, (m, m, rad).
    pub fn believed(&self, step: &Vector3<f64>) -> Vector3<f64> {
        let e = &self.errors;
        Vector3::new((1.0 + e.x) * step.x, step.y, (1.0 + e.y) * step.z + e.z * step.x)
    }

    /// Predicts over the arc `step`. Returns what the unknown errors add to the
    /// covariance of the pose at its end.
    pub fn predict(&mut self, step: &Vector3<f64>) -> Matrix3<f64> {
        let believed = self.believed(step);
        let back = SE2::exp(&believed).inverse().adjoint();
        let mut of_twist = Matrix3::zeros();
        of_twist[(0, 0)] = step.x;
        of_twist[(2, 1)] = step.z;
        of_twist[(2, 2)] = step.x;
        let by = right_jacobian(&believed) * of_twist;
        let both = back * self.cross * by.transpose();
        let added = both + both.transpose() + by * self.covariance * by.transpose();
        self.cross = back * self.cross + by * self.covariance;
        symmetric(&added)
    }

    /// Corrects by a line. `pose_covariance` is that before the line.
    pub fn correct(&mut self, innovation: &LineInnovation, pose_covariance: &Matrix3<f64>) {
        let LineInnovation { nu, h, s, .. } = innovation;
        let Some(inverse) = s.try_inverse() else { return };
        let gain = self.cross.transpose() * h.transpose() * inverse;
        let of_pose = pose_covariance * h.transpose() * inverse;
        let errors = self.errors + gain * nu;
        let covariance = symmetric(&(self.covariance - gain * s * gain.transpose()));
        let jr = right_jacobian(&(of_pose * nu));
        let cross = jr * (self.cross - of_pose * (h * self.cross));
        let mut all = errors.iter().chain(covariance.iter()).chain(cross.iter());
        if all.all(|v| v.is_finite()) && covariance.diagonal().min() > 0.0 {
            *self = Self { errors, covariance, cross };
        }
        if errors.component_div(&Vector3::from(UNKNOWN)).amax() > MOST_DEVIATIONS {
            *self = Self::unknown();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::carried;
    use nalgebra::{Matrix2, Matrix2x3};

    #[test]
    fn the_pose_moves_with_the_errors_as_it_says() {
        let steps: Vec<_> =
            (0..40).map(|k| Vector3::new(0.01, 0.0, 0.002 * f64::from(k))).collect();
        let end = |errors: Vector3<f64>| {
            let wheels = WheelErrors { errors, ..WheelErrors::unknown() };
            steps.iter().fold(SE2::identity(), |pose, step| pose.boxplus(&wheels.believed(step)))
        };
        let at = Vector3::new(0.01, -0.02, 0.1);
        let mut wheels = WheelErrors { errors: at, ..WheelErrors::unknown() };
        let mut pose = Matrix3::zeros();
        for step in &steps {
            pose = carried(&pose, &SE2::exp(&wheels.believed(step))) + wheels.predict(step);
        }
        let columns = [0, 1, 2].map(|k| {
            let mut by = Vector3::zeros();
            by[k] = 1e-6;
            (end(at + by).boxminus(&end(at)) - end(at - by).boxminus(&end(at))) / 2e-6
        });
        let j = Matrix3::from_columns(&columns);
        let unknown = &wheels.covariance;
        assert!((wheels.cross - j * unknown).norm() < 1e-6, "{}", wheels.cross);
        assert!((pose - j * unknown * j.transpose()).norm() < 1e-6, "{pose}");
    }

    #[test]
    fn what_is_too_much_for_wheels_is_forgotten() {
        let h = Matrix2x3::new(-1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
        let of = |off: f64| {
            let mut wheels = WheelErrors::unknown();
            let covariance = wheels.predict(&Vector3::new(1.0, 0.0, 0.0));
            let (nu, r) = (h * Vector3::new(off, 0.0, 0.0), Matrix2::identity() * 1e-8);
            let innovation = LineInnovation { nu, h, r, s: h * covariance * h.transpose() + r };
            wheels.correct(&innovation, &covariance);
            wheels
        };
        assert!((of(-0.149).errors.x + 0.149).abs() < 1e-3);
        assert_eq!(of(-0.151), WheelErrors::unknown());
    }

    #[test]
    fn a_turn_per_metre_is_learned_from_headings() {
        // Straight ways of 0.1 m; a line ahead and one to the side after each.
        let (mut wheels, truth) = (WheelErrors::unknown(), Vector3::new(0.02, 0.0, 0.19));
        let step = Vector3::new(0.1, 0.0, 0.0);
        let true_wheels = WheelErrors { errors: truth, ..WheelErrors::unknown() };
        let (mut at, mut pose) = (SE2::identity(), SE2::identity());
        let mut covariance = Matrix3::identity() * 1e-8;
        for _ in 0..60 {
            at = at.boxplus(&true_wheels.believed(&step));
            let believed = wheels.believed(&step);
            covariance = carried(&covariance, &SE2::exp(&believed))
                + wheels.predict(&step)
                + Matrix3::identity() * 1e-8;
            pose = pose.boxplus(&believed);
            for h in [
                Matrix2x3::new(0.0, 0.0, -1.0, -1.0, 0.0, 0.0),
                Matrix2x3::new(0.0, 0.0, -1.0, 0.0, -1.0, 0.0),
            ] {
                let (nu, r) = (h * at.boxminus(&pose), Matrix2::identity() * 1e-6);
                let innovation = LineInnovation { nu, h, r, s: h * covariance * h.transpose() + r };
                wheels.correct(&innovation, &covariance);
                (pose, covariance) =
                    super::super::updated(&pose, &covariance, &innovation).unwrap();
            }
        }
        let off = wheels.errors - truth;
        assert!(off.x.abs() < 2e-3 && off.z.abs() < 5e-3, "{off}");
        assert!(wheels.covariance[(2, 2)].sqrt() < 0.02, "{}", wheels.covariance);
        // Without turns nothing is learned of their scale.
        assert!((wheels.covariance[(1, 1)].sqrt() - UNKNOWN[1]).abs() < 1e-3);
    }
}
