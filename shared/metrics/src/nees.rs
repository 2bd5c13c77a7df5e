//! The normalised estimation error squared (NEES) of a pose.
//!
//! Source: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications
//! to Tracking and Navigation* (Wiley, 2001), §5.4.2. Departure: the error is
//! taken on the group, in the tangent space at the estimate, where
//! [`Estimate::covariance`](rusty_contract::Estimate::covariance) is defined: no angle
//! jumps at ±π.

use nalgebra::{Matrix3, Vector3};
use rusty_geometry::SE2;

/// Numbers above and below the diagonal may differ by this part of what a
/// correlation of 1 would be.
const ASYMMETRY: f64 = 1e-6;
/// Variance that is left of a component when those before it are known, as part of
/// its variance: with less, the covariance is not of full rank.
const LEAST_LEFT: f64 = 1e-12;
/// Larger than this is no sample but an accident.
pub const GREATEST: f64 = 1e100;

/// τᵀ P⁻¹ τ with τ = truth ⊟ estimate and `covariance` P, row by row. `None`
/// where P is not symmetric, not positive definite, or not of full rank to
/// twelve digits.
#[must_use]
pub fn nees(truth: &SE2, estimate: &SE2, covariance: &[f64; 9]) -> Option<f64> {
    let p = Matrix3::from_row_slice(covariance);
    let scale = p.diagonal().map(f64::sqrt);
    // Freed of its units, which say nothing of its rank.
    let c = Matrix3::from_fn(|i, j| 0.5 * (p[(i, j)] + p[(j, i)]) / (scale[i] * scale[j]));
    let skew = Matrix3::from_fn(|i, j| (p[(i, j)] - p[(j, i)]).abs() / (scale[i] * scale[j]));
    // Written so that NaN does not pass.
    if !skew.iter().all(|part| *part <= ASYMMETRY) {
        return None;
    }
    let root = c.cholesky()?.unpack();
    if !root.diagonal().iter().all(|left| left * left >= LEAST_LEFT) {
        return None;
    }
    let tau: Vector3<f64> = truth.boxminus(estimate).component_div(&scale);
    let nees = root.solve_lower_triangular(&tau)?.norm_squared();
    (nees <= GREATEST).then_some(nees)
}
