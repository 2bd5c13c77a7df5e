//! The ellipse that holds 95 % of a normal distribution in the plane.

use rusty_geometry::trig;

/// 95 % of χ² with two degrees of freedom: −2 ln 0.05.
pub const NINETY_FIVE: f64 = 5.991_464_547_107_98;
/// Corners of a drawn ellipse.
const CORNERS: u32 = 72;

/// Returns the ellipse of a covariance (variance of x, covariance, variance of
/// y) about its centre as what a unit circle becomes: [x by x, y by x, y by y].
/// `None` of numbers that are no covariance.
#[must_use]
pub fn ellipse([xx, xy, yy]: [f64; 3]) -> Option<[f64; 3]> {
    let is_covariance = xx >= 0.0 && yy >= 0.0 && xy.is_finite() && (xx + yy).is_finite();
    let [xx, xy, yy] = [xx, xy, yy].map(|v| NINETY_FIVE * v);
    let by_x = xx.sqrt();
    let across = if by_x > 0.0 { xy / by_x } else { 0.0 };
    let by_y = (yy - across * across).max(0.0).sqrt();
    let all = [by_x, across, by_y];
    (is_covariance && all.iter().all(|v| v.is_finite())).then_some(all)
}

/// Returns the [`ellipse`] of a position in the world frame from the covariance of a pose
/// in its body frame, row by row (m², m·rad, rad²), and its heading.
#[must_use]
pub fn of_pose(heading_rad: f64, p: &[f64; 9]) -> Option<[f64; 3]> {
    let [a, b, c] = [p[0], 0.5 * (p[1] + p[3]), p[4]];
    let is_covariance = a >= 0.0 && c >= 0.0 && b.is_finite() && (a + c).is_finite();
    let (s, k) = trig::sin_cos(heading_rad);
    let xx = k * k * a - 2.0 * k * s * b + s * s * c;
    let xy = k * s * (a - c) + (k * k - s * s) * b;
    let yy = s * s * a + 2.0 * k * s * b + k * k * c;
    // Rounding may leave a hair less than none.
    is_covariance.then(|| ellipse([xx.max(0.0), xy, yy.max(0.0)]))?
}

/// Returns the corners of an ellipse about `centre`, the first again at the end.
#[must_use]
pub fn outline([x, y]: [f64; 2], [xx, yx, yy]: [f64; 3]) -> Vec<[f64; 2]> {
    let corner = |k: u32| {
        let turn = core::f64::consts::TAU * f64::from(k % CORNERS) / f64::from(CORNERS);
        let (s, c) = trig::sin_cos(turn);
        [x + xx * c, y + yx * c + yy * s]
    };
    (0..=CORNERS).map(corner).collect()
}

/// Returns the corners of a circle, the first again at the end.
#[must_use]
pub fn circle(centre: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    outline(centre, [radius, 0.0, radius])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ellipse_has_the_axes_of_the_covariance() {
        let k = NINETY_FIVE.sqrt();
        assert_eq!(ellipse([1.0, 0.0, 0.0]), Some([k, 0.0, 0.0]));
        assert_eq!(ellipse([0.0; 3]), Some([0.0; 3]));
        for bad in [[f64::NAN, 0.0, 1.0], [1.0, 0.0, -1.0], [f64::MAX, 0.0, f64::MAX]] {
            assert_eq!(ellipse(bad), None);
        }
        // Along (1, 1) with variance 5, nothing across.
        let found = outline([0.0; 2], ellipse([2.5; 3]).unwrap());
        let far = found.iter().map(|p| trig::hypot(p[0], p[1])).fold(0.0, f64::max);
        assert!((far - (5.0 * NINETY_FIVE).sqrt()).abs() < 1e-2, "{far}");
        assert!(found.iter().all(|p| (p[0] - p[1]).abs() < 1e-7));
        assert_eq!(found.first(), found.last());
    }
}
