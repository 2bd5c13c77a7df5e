//! Small pieces of calculus in the tangent space of SE(2).
//!
//! Source: J. Solà, J. Deray, D. Atchuthan, *A micro Lie theory for state
//! estimation in robotics* (arXiv:1812.01537), eqs. (143) and (163): the right
//! Jacobian of the exponential map.
//!
//! Departure: its inverse is written as a polynomial in ad(τ). Because
//! ad³ = −θ² ad on SE(2), the series of Bernoulli numbers ends after the square:
//! J_r⁻¹ = 1 + ad/2 + (1 − θ/2 · cot θ/2)/θ² · ad².

use nalgebra::{Matrix3, Vector3};
use rusty_contract::Estimate;
use rusty_geometry::{SE2, trig};

use crate::Motion;

/// The matrix of the Lie bracket with `tau`.
fn ad(tau: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -tau.z, tau.y, tau.z, 0.0, -tau.x, 0.0, 0.0, 0.0)
}

/// J_r(τ): exp(τ + δ) = exp(τ) ∘ exp(J_r(τ) δ) for small δ. In the same way,
/// 1 − (1 − cos θ)/θ² · ad + (θ − sin θ)/θ³ · ad².
pub fn right_jacobian(tau: &Vector3<f64>) -> Matrix3<f64> {
    let (ad, theta_rad) = (ad(tau), tau.z);
    let half = trig::sinc(0.5 * theta_rad);
    let second = if theta_rad.abs() < 1e-2 {
        1.0 / 6.0 - theta_rad * theta_rad / 120.0
    } else {
        (1.0 - trig::sinc(theta_rad)) / (theta_rad * theta_rad)
    };
    Matrix3::identity() - ad * (0.5 * half * half) + ad * ad * second
}

/// J_r⁻¹(τ): log(exp(τ) ∘ exp(δ)) = τ + J_r⁻¹(τ) δ for small δ.
pub fn right_jacobian_inverse(tau: &Vector3<f64>) -> Matrix3<f64> {
    let ad = ad(tau);
    let half_rad = 0.5 * tau.z;
    // Below a milliradian the next term of the series is beyond the last digit.
    let factor = if half_rad.abs() < 5e-4 {
        1.0 / 12.0 + tau.z * tau.z / 720.0
    } else {
        (1.0 - trig::cos(half_rad) / trig::sinc(half_rad)) / (tau.z * tau.z)
    };
    Matrix3::identity() + ad * 0.5 + ad * ad * factor
}

/// A belief about the motion to now, seen from another guess of it: mean and
/// covariance of the τ with truth = `guess` ⊞ τ.
pub fn seen_from(belief: &Motion, guess: &SE2) -> (Vector3<f64>, Matrix3<f64>) {
    let mean = belief.now_in_then.boxminus(guess);
    let j = right_jacobian_inverse(&mean);
    (mean, j * belief.covariance * j.transpose())
}

/// One motion after another, with independent errors.
pub fn chained(first: &Motion, second: &Motion) -> Motion {
    Motion {
        now_in_then: first.now_in_then * second.now_in_then,
        covariance: symmetric(&second.propagate(&first.covariance)),
    }
}

/// A motion from an uncertain pose: where it ends, and how sure that is.
pub fn placed(from: &SE2, covariance: &Matrix3<f64>, motion: &Motion) -> (SE2, Matrix3<f64>) {
    (*from * motion.now_in_then, symmetric(&motion.propagate(covariance)))
}

/// A symmetric matrix without its negative part, and without the last digits in
/// which its halves differ.
pub fn at_least_zero(matrix: &Matrix3<f64>) -> Matrix3<f64> {
    let mut eigen = symmetric(matrix).symmetric_eigen();
    eigen.eigenvalues.apply(|value| *value = value.max(0.0));
    symmetric(&eigen.recompose())
}

/// The covariance of a pose whose axes are as unsure as each other, and its heading.
pub fn independent(std_m: f64, std_rad: f64) -> Matrix3<f64> {
    let variances = Vector3::new(std_m * std_m, std_m * std_m, std_rad * std_rad);
    Matrix3::from_diagonal(&variances)
}

/// The mean of a matrix and its transpose.
pub fn symmetric(matrix: &Matrix3<f64>) -> Matrix3<f64> {
    (matrix + matrix.transpose()) * 0.5
}

/// A covariance as an answer carries it, row by row.
fn rows(covariance: &Matrix3<f64>) -> [f64; 9] {
    std::array::from_fn(|i| covariance[(i / 3, i % 3)])
}

/// The answer that says a pose, world frame, and the covariance of its error τ.
pub fn estimate(pose_in_world: &SE2, covariance: &Matrix3<f64>) -> Estimate {
    Estimate::new(*pose_in_world).with_covariance(rows(covariance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_jacobians_undo_each_other() {
        for theta_rad in [0.0, 1e-4, 0.009_9, 0.010_1, -0.8, 3.0] {
            let tau = Vector3::new(0.7, -1.3, theta_rad);
            let product = right_jacobian(&tau) * right_jacobian_inverse(&tau);
            assert!((product - Matrix3::identity()).norm() < 1e-10, "{theta_rad}: {product}");
        }
    }

    #[test]
    fn the_inverse_jacobian_is_that_of_finite_differences() {
        for tau in [
            Vector3::new(0.3, -0.2, 0.0),
            Vector3::new(0.3, -0.2, 9e-4),
            Vector3::new(0.3, -0.2, 1.1e-3),
            Vector3::new(-1.0, 2.0, 0.7),
            Vector3::new(0.4, 0.1, -3.0),
        ] {
            let j = right_jacobian_inverse(&tau);
            for axis in 0..3 {
                let mut delta = Vector3::zeros();
                delta[axis] = 1e-6;
                let moved = |d: &Vector3<f64>| SE2::exp(&tau).boxplus(d).log();
                let found = (moved(&delta) - moved(&-delta)) / 2e-6;
                assert!((found - j.column(axis)).norm() < 1e-9, "{tau} {axis}: {found} {j}");
            }
        }
    }

    #[test]
    fn what_is_negative_goes_and_the_rest_stays() {
        let matrix = Matrix3::new(2.0, 1.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, -1.0);
        let mended = at_least_zero(&matrix);
        let expected = Matrix3::new(2.0, 1.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 0.0);
        assert!((mended - expected).norm() < 1e-12, "{mended}");
        assert_eq!(mended, mended.transpose());
    }
}
