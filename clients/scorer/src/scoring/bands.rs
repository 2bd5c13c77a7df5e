//! What a covariance promises: where the error lies with a probability of 95 %.
//!
//! The covariance P of an estimate belongs to the error τ (m, m, rad) on the
//! group, truth = estimate ⊞ τ, in the frame of the estimated body.
//!
//! Sources: Y. Bar-Shalom, X. Li, T. Kirubarajan, *Estimation with Applications
//! to Tracking and Navigation* (2001), §5.4 (normalised squared error and its
//! χ² band) and its table of χ² quantiles; F. Satterthwaite, *An approximate
//! distribution of estimates of variance components* (1946), and E. Wilson and
//! M. Hilferty, *The distribution of chi-square* (1931), for the length of a
//! Gaussian vector. Departure: ellipses are drawn about the position in the
//! plane, to first order: the bend that the heading's uncertainty gives them is
//! left out.

use rusty_contract::Estimate;
use rusty_contract::score::ReferenceNoise;
use rusty_geometry::SE2;
use rusty_plot::ellipse::of_pose;

/// Two-sided 95 % of χ² with three degrees of freedom: 2.5 % lie below, 2.5 %
/// above.
pub const NEES_BAND: [f64; 2] = [0.215_795_282_623_897_94, 9.348_403_604_496_148];
/// Two-sided 95 % of a standard normal variable, and one-sided.
const TWO_SIDED: f64 = 1.959_963_984_540_054;
const ONE_SIDED: f64 = 1.644_853_626_951_472_7;
/// An ellipse larger than this is drawn as if it were this large, m.
const LARGEST_M: f64 = 1e6;

/// The normalised squared error τᵀ P⁻¹ τ of an estimate, compared with truths of this noise;
/// `None` where there is no covariance, or none of full rank.
#[must_use]
pub fn nees(truth: &SE2, estimate: &Estimate, reference: &ReferenceNoise) -> Option<f64> {
    let covariance = reference.added_to(&estimate.covariance?);
    rusty_metrics::nees(truth, &estimate.pose_in_world, &covariance)
}

/// The radius that the position error stays below with a probability of 95 %,
/// m; right to some percent of itself.
#[must_use]
pub fn position_radius_m(covariance: &[f64; 9]) -> Option<f64> {
    let [a, b, c] = plane(covariance)?;
    // The squared length is a sum of χ² of one degree, weighed by the
    // eigenvalues; it has nearly the distribution of `scale` · χ² of `degrees`.
    let (sum, squares) = (a + c, a * a + 2.0 * b * b + c * c);
    if sum <= 0.0 {
        return Some(0.0);
    }
    let (scale, degrees) = (squares / sum, sum * sum / squares);
    let width = 2.0 / (9.0 * degrees);
    let root = 1.0 - width + ONE_SIDED * width.sqrt();
    Some((scale * degrees * root * root * root).sqrt()).filter(|r| r.is_finite())
}

/// The heading error stays between minus and plus this with a probability of
/// 95 %, rad, at most π.
#[must_use]
pub fn heading_reach_rad(covariance: &[f64; 9]) -> Option<f64> {
    let reach_rad = TWO_SIDED * covariance[8].sqrt();
    (!reach_rad.is_nan()).then(|| reach_rad.min(std::f64::consts::PI))
}

/// The ellipse that holds the position with a probability of 95 %, as what a
/// unit circle becomes: [x by x, y by x, y by y] in m, in the world frame, about
/// the estimated position.
#[must_use]
pub fn ellipse_m(estimate: &Estimate) -> Option<[f64; 3]> {
    let all = of_pose(estimate.pose_in_world.theta(), &estimate.covariance?)?;
    Some(all.map(|v| v.clamp(-LARGEST_M, LARGEST_M)))
}

/// Variances and covariance of x and y in the body frame, m²; `None` if they
/// are no numbers or no covariance.
fn plane(covariance: &[f64; 9]) -> Option<[f64; 3]> {
    let [a, b, c] = [covariance[0], 0.5 * (covariance[1] + covariance[3]), covariance[4]];
    let sound = a >= 0.0 && c >= 0.0 && b.is_finite() && (a + c).is_finite();
    sound.then_some([a, b, c])
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use rusty_geometry::trig;
    use rusty_metrics::chi_square;
    use rusty_plot::ellipse::NINETY_FIVE as PLANE;

    #[test]
    fn the_quantiles_are_those_of_the_distribution() {
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9 * b, "{a}, {b}");
        let [low, high] = chi_square::band(0.95, 3.0);
        close(NEES_BAND[0], low);
        close(NEES_BAND[1], high);
        close(PLANE, chi_square::quantile(0.95, 2.0));
        close(TWO_SIDED * TWO_SIDED, chi_square::quantile(0.95, 1.0));
        close(ONE_SIDED * ONE_SIDED, chi_square::quantile(0.90, 1.0));
    }

    const EXACT: ReferenceNoise = ReferenceNoise { std_m: 0.0, std_rad: 0.0 };

    fn estimate(theta_rad: f64, covariance: [f64; 9]) -> Estimate {
        let pose = SE2::new(1.0, 2.0, theta_rad);
        Estimate { covariance: Some(covariance), ..Estimate::from(pose) }
    }

    #[test]
    fn squared_errors_are_taken_on_the_group() {
        let p = [4.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.25];
        // Across the half turn: the heading is wrong by 0.5, not by 2π − 0.5.
        let e = estimate(std::f64::consts::PI - 0.25, p);
        let truth = e.pose_in_world.boxplus(&Vector3::new(2.0, -1.0, 0.5));
        assert!(truth.theta() < 0.0);
        assert!((nees(&truth, &e, &EXACT).unwrap() - 3.0).abs() < 1e-9);
        // A truth as unsure as the estimate halves it.
        let as_unsure = ReferenceNoise { std_m: 2.0, std_rad: 0.5 };
        let along = e.pose_in_world.boxplus(&Vector3::new(2.0, 0.0, 0.5));
        assert!((nees(&along, &e, &EXACT).unwrap() - 2.0).abs() < 1e-9);
        assert!((nees(&along, &e, &as_unsure).unwrap() - 1.0).abs() < 1e-9);
        assert_eq!(nees(&truth, &estimate(0.0, [0.0; 9]), &EXACT), None);
        assert_eq!(nees(&truth, &Estimate::from(truth), &EXACT), None);
        assert_eq!(nees(&truth, &estimate(0.0, [f64::INFINITY; 9]), &EXACT), None);
    }

    /// P(length ≤ r) of a Gaussian vector with these standard deviations, by
    /// integrating over the directions.
    fn share(sx: f64, sy: f64, r: f64) -> f64 {
        let n = 20_000;
        let sum: f64 = (0..n)
            .map(|k| {
                let (s, c) = trig::sin_cos(std::f64::consts::TAU * (f64::from(k) + 0.5) / 2e4);
                let q = c * c / (sx * sx) + s * s / (sy * sy);
                (1.0 - trig::exp(-0.5 * r * r * q)) / q
            })
            .sum();
        sum / (f64::from(n) * sx * sy)
    }

    #[test]
    fn the_radius_holds_95_percent_whatever_the_shape() {
        for ratio in [1.0, 0.8, 0.5, 0.3, 0.1, 0.03] {
            let (sx, sy) = (2.0, 2.0 * ratio);
            let p = [sx * sx, 0.0, 0.0, 0.0, sy * sy, 0.0, 0.0, 0.0, 1.0];
            let held = share(sx, sy, position_radius_m(&p).unwrap());
            assert!((held - 0.95).abs() < 0.006, "{ratio}: {held}");
        }
        assert_eq!(position_radius_m(&[0.0; 9]), Some(0.0));
        assert_eq!(position_radius_m(&[f64::NAN; 9]), None);
        assert_eq!(position_radius_m(&[f64::MAX; 9]), None);
    }

    #[test]
    fn an_ellipse_turns_with_its_body() {
        let p = [1.0, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 1.0];
        let k = PLANE.sqrt();
        let close = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
        assert!(close(ellipse_m(&estimate(0.0, p)).unwrap(), [k, 0.0, 0.1 * k]));
        let quarter = std::f64::consts::FRAC_PI_2;
        assert!(close(ellipse_m(&estimate(quarter, p)).unwrap(), [0.1 * k, 0.0, k]));
        // L Lᵀ is the covariance in the world.
        let [xx, yx, yy] = ellipse_m(&estimate(0.5 * quarter, p)).unwrap();
        assert!(close(
            [xx * xx, xx * yx, yx * yx + yy * yy],
            [0.505, 0.495, 0.505].map(|v| v * PLANE)
        ));
        assert_eq!(ellipse_m(&estimate(0.0, [1e300; 9])).unwrap()[..2], [LARGEST_M; 2]);
        assert_eq!(ellipse_m(&estimate(0.0, [f64::NAN; 9])), None);
        assert_eq!(ellipse_m(&estimate(0.3, [0.0; 9])), Some([0.0; 3]));
    }

    #[test]
    fn a_heading_cannot_be_worse_than_half_a_turn() {
        let mut p = [0.0; 9];
        p[8] = 0.01;
        assert!((heading_reach_rad(&p).unwrap() - 0.196).abs() < 1e-4);
        p[8] = 1e9;
        assert_eq!(heading_reach_rad(&p), Some(std::f64::consts::PI));
        p[8] = -1.0;
        assert_eq!(heading_reach_rad(&p), None);
    }
}
