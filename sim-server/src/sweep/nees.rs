//! The normalised estimation error squared (NEES) of a pose.
//!
//! Source: Y. Bar-Shalom, X. Li, T. Kirubarajan, *Estimation with Applications to
//! Tracking and Navigation* (2001), §5.4.2, eq. (5.4.2-1). The error is taken on
//! the group, τ = truth ⊟ estimate, as the covariance is reported (truth =
//! estimate ⊞ τ): a heading error across ±π is as small as it is.

use nalgebra::{Matrix3, Vector3};
use rusty_contract::Estimate;
use rusty_geometry::SE2;

/// τᵀ P⁻¹ τ; `None` where no covariance is reported, or one that is none: not
/// positive definite.
#[must_use]
pub fn nees(estimate: &Estimate, truth: &SE2) -> Option<f64> {
    let covariance = Matrix3::from_row_slice(&estimate.covariance?);
    let error: Vector3<f64> = truth.boxminus(&estimate.pose_in_world);
    let whitened = covariance.cholesky()?.l().solve_lower_triangular(&error)?;
    Some(whitened.norm_squared()).filter(|nees| nees.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(theta_rad: f64, covariance: Option<[f64; 9]>) -> Estimate {
        Estimate { covariance, ..SE2::new(1.0, 2.0, theta_rad).into() }
    }

    #[test]
    fn by_hand_and_across_the_half_turn() {
        let diagonal = [0.04, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.0025];
        let believed = estimate(3.12, Some(diagonal));
        // 0.1 m across its own axes, and 0.05 rad further: over the half turn.
        let tau = Vector3::new(0.2, -0.1, 0.05);
        let truth = believed.pose_in_world.boxplus(&tau);
        assert!(truth.theta() < 0.0, "{truth:?}");
        assert!((nees(&believed, &truth).unwrap() - 3.0).abs() < 1e-12);
        // Correlated: P = L Lᵀ with L = [2 0; 1 1] in x and y, τ = L (1, 1).
        let correlated = [4.0, 2.0, 0.0, 2.0, 2.0, 0.0, 0.0, 0.0, 1.0];
        let believed = estimate(0.3, Some(correlated));
        let truth = believed.pose_in_world.boxplus(&Vector3::new(2.0, 2.0, 1.0));
        assert!((nees(&believed, &truth).unwrap() - 3.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_covariance_has_none() {
        let truth = SE2::new(1.0, 2.0, 0.3);
        assert_eq!(nees(&estimate(0.3, None), &truth), None);
        for broken in [[0.0; 9], [1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0]] {
            assert_eq!(nees(&estimate(0.3, Some(broken)), &truth), None);
        }
        let whole = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        assert_eq!(nees(&estimate(0.3, Some(whole)), &truth), Some(0.0));
    }
}
