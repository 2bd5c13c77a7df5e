//! A straight wall from beams: the most likely line, and how sure it is.
//!
//! A line in Hessian form is n·p = ρ with n = (cos α, sin α) and ρ ≥ 0. A beam
//! in direction d meets it at the range h = ρ / (n·d). Errors of a laser are
//! along its beams; so the most likely line is the one with the least
//! Σ (rᵢ − hᵢ)²/σ², and its covariance is the inverse of Σ ∇hᵢ ∇hᵢᵀ/σ².
//!
//! Source: R. Siegwart, I. Nourbakhsh, *Introduction to Autonomous Mobile Robots*
//! (2004), §4.3.1, for line and first guess; K. O. Arras, R. Siegwart, *Feature
//! extraction and scene interpretation for map-based navigation and map
//! building* (SPIE 3210, 1997), for the covariance of (α, ρ).
//!
//! Departures, and why:
//! * Both weigh points by a variance across the line that is taken from the
//!   *measured* range. A beam that came out long then counts for more, which
//!   bends lines that are seen at grazing angles. Here the error is that of the
//!   range itself, at the range the line predicts; the closed form of the source
//!   is where Gauss and Newton's iteration begins.
//! * The covariance is that of the iteration's normal equations, which is the
//!   same thing as Arras' propagation at the least of the sum.

use nalgebra::{Matrix2, Point2, Vector2};
use rusty_geometry::{SE2, trig, wrap_angle};

/// A line seen at a flatter angle than this (its cosine) says nothing of its
/// distance: a beam along a wall.
const FLATTEST: f64 = 0.01;

/// A line n·p = ρ and the covariance of (α, ρ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Direction α of the normal n, which points from the frame's origin to the
    /// line, rad.
    pub alpha_rad: f64,
    /// Distance ρ of the line from the origin, m; at least 0.
    pub rho_m: f64,
    /// Covariance of (α, ρ): rad², rad m, m².
    pub covariance: Matrix2<f64>,
}

/// What a beam measured: its direction (of length 1) and the range, m, both
/// from the origin of the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it points.
    pub direction: Vector2<f64>,
    /// How far it came, m.
    pub range_m: f64,
}

impl Ray {
    /// Where it ended, m.
    pub fn end(&self) -> Vector2<f64> {
        self.direction * self.range_m
    }
}

impl Line {
    /// The unit normal n.
    pub fn normal(&self) -> Vector2<f64> {
        let (s, c) = trig::sin_cos(self.alpha_rad);
        Vector2::new(c, s)
    }

    /// The range at which a beam in this direction meets the line, m; `None` for
    /// one that points along it or away.
    pub fn range_m(&self, direction: &Vector2<f64>) -> Option<f64> {
        meets(&self.normal(), self.rho_m, direction)
    }

    /// The most likely line through the ends of `rays`, whose ranges have
    /// independent errors of `range_std_m`. `None` for fewer than two, for rays
    /// that no line explains, and for lines through the origin.
    pub fn fit(rays: &[Ray], range_std_m: f64) -> Option<Self> {
        let (mut alpha_rad, mut rho_m) = guess(rays)?;
        let mut information = Matrix2::zeros();
        for _ in 0..10 {
            let (s, c) = trig::sin_cos(alpha_rad);
            let (normal, along) = (Vector2::new(c, s), Vector2::new(-s, c));
            let mut gradient = Vector2::zeros();
            information = Matrix2::zeros();
            for ray in rays {
                let cosine = normal.dot(&ray.direction);
                let h = meets(&normal, rho_m, &ray.direction)?;
                let by = Vector2::new(-h * along.dot(&ray.direction) / cosine, 1.0 / cosine);
                gradient += by * (ray.range_m - h);
                information += by * by.transpose();
            }
            let step = information.try_inverse()? * gradient;
            alpha_rad += step.x;
            rho_m += step.y;
            // NaN ends it as well, and is refused below.
            if !(step.x.abs() > 1e-9 || step.y.abs() > 1e-9) {
                break;
            }
        }
        let covariance = information.try_inverse()? * (range_std_m * range_std_m);
        let line = Self { alpha_rad: wrap_angle(alpha_rad), rho_m, covariance };
        let whole = alpha_rad.is_finite() && rho_m > 0.0 && rho_m.is_finite();
        (whole && covariance.iter().all(|v| v.is_finite())).then_some(line)
    }

    /// The greatest distance of a range from what the line predicts, m; infinite
    /// where a ray does not meet it at all.
    pub fn worst_m(&self, rays: &[Ray]) -> f64 {
        let normal = self.normal();
        let error_m = |ray: &Ray| match meets(&normal, self.rho_m, &ray.direction) {
            Some(h) => (ray.range_m - h).abs(),
            None => f64::INFINITY,
        };
        rays.iter().map(error_m).fold(0.0, f64::max)
    }

    /// The point of the line whose distance across it is known best, and the
    /// variance of that distance, m². Its error has nothing to do with that of α.
    ///
    /// A point s along the line (the normal turned to the left) is off by
    /// δρ − s δα.
    pub fn firm_point(&self) -> (Point2<f64>, f64) {
        let [alpha, both, rho] = [(0, 0), (0, 1), (1, 1)].map(|at| self.covariance[at]);
        let s_m = if alpha > 0.0 { both / alpha } else { 0.0 };
        let normal = self.normal();
        let point = normal * self.rho_m + Vector2::new(-normal.y, normal.x) * s_m;
        (Point2::from(point), (rho - both * s_m).max(0.0))
    }

    /// The same line in the frame in which this one's has the pose `frame`. The
    /// normal keeps its direction in the plane; so ρ may become negative.
    pub fn seen_from(&self, frame: &SE2) -> Self {
        let alpha_rad = wrap_angle(self.alpha_rad + frame.theta());
        let (s, c) = trig::sin_cos(alpha_rad);
        let offset_m = frame.translation();
        let by = Matrix2::new(1.0, 0.0, Vector2::new(-s, c).dot(&offset_m), 1.0);
        Self {
            alpha_rad,
            rho_m: self.rho_m + Vector2::new(c, s).dot(&offset_m),
            covariance: by * self.covariance * by.transpose(),
        }
    }
}

fn meets(normal: &Vector2<f64>, rho_m: f64, direction: &Vector2<f64>) -> Option<f64> {
    let cosine = normal.dot(direction);
    (cosine > FLATTEST).then(|| rho_m / cosine)
}

/// The line with the least sum of squared distances across it (Siegwart and
/// Nourbakhsh, eqs. 4.73 and 4.74, all weights 1).
fn guess(rays: &[Ray]) -> Option<(f64, f64)> {
    if rays.len() < 2 {
        return None;
    }
    let mean = rays.iter().map(Ray::end).sum::<Vector2<f64>>() / rays.len() as f64;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for ray in rays {
        let d = ray.end() - mean;
        (xx, xy, yy) = (xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y);
    }
    let alpha_rad = 0.5 * trig::atan2(-2.0 * xy, yy - xx);
    let (s, c) = trig::sin_cos(alpha_rad);
    let rho_m = c * mean.x + s * mean.y;
    let turned = alpha_rad + std::f64::consts::PI;
    Some(if rho_m < 0.0 { (turned, -rho_m) } else { (alpha_rad, rho_m) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    /// Exact rays onto the line (α, ρ) under these bearings.
    fn rays(alpha_rad: f64, rho_m: f64, bearings_rad: &[f64]) -> Vec<Ray> {
        let ray = |bearing_rad: &f64| {
            let (s, c) = trig::sin_cos(*bearing_rad);
            let range_m = rho_m / trig::cos(bearing_rad - alpha_rad);
            Ray { direction: Vector2::new(c, s), range_m }
        };
        bearings_rad.iter().map(ray).collect()
    }

    #[test]
    fn a_case_worked_by_hand() {
        // A wall at x = 2, seen at −45°, 0 and 45°: ranges 2√2, 2, 2√2. With
        // ∂h/∂α = −h tan φ and ∂h/∂ρ = 1/cos φ the sums are 8 + 0 + 8, 2 + 1 + 2,
        // and 0 off the diagonal.
        let eighth = std::f64::consts::FRAC_PI_4;
        let mut rays = rays(0.0, 2.0, &[-eighth, 0.0, eighth]);
        let line = Line::fit(&rays, 0.02).unwrap();
        assert!(line.alpha_rad.abs() < 1e-12 && (line.rho_m - 2.0).abs() < 1e-12, "{line:?}");
        let expected = Matrix2::new(0.0004 / 16.0, 0.0, 0.0, 0.0004 / 5.0);
        assert!((line.covariance - expected).norm() < 1e-15, "{line:?}");
        // The middle beam 5 cm too long: by symmetry ρ alone moves, by 0.05 / 5.
        rays[1].range_m += 0.05;
        let line = Line::fit(&rays, 0.02).unwrap();
        assert!(line.alpha_rad.abs() < 1e-12 && (line.rho_m - 2.01).abs() < 1e-9, "{line:?}");
        // Then its range is 4 cm off, the others 1 cm · √2.
        assert!((line.worst_m(&rays) - 0.04).abs() < 1e-9);
    }

    #[test]
    fn the_covariance_is_the_spread() {
        let degrees = |list: &[f64]| list.iter().map(|d| d.to_radians()).collect::<Vec<_>>();
        let every = |from: i32, to: i32| (from..=to).map(|k| f64::from(2 * k)).collect::<Vec<_>>();
        // Straight ahead, along a corridor at grazing angles, far and short.
        let cases = [
            (0.0, 3.0, degrees(&every(-12, 12))),
            (1.6, 0.6, degrees(&every(5, 40))),
            (-2.0, 6.0, degrees(&[-120.0, -118.0, -116.0, -114.0, -112.0, -110.0, -108.0])),
        ];
        let (mut random, std_m, count) = (Random::new(1, 1), 0.02, 20_000);
        for (alpha_rad, rho_m, bearings_rad) in cases {
            let exact = rays(alpha_rad, rho_m, &bearings_rad);
            let said = Line::fit(&exact, std_m).unwrap();
            assert!((said.rho_m - rho_m).abs() < 1e-9, "{said:?}");
            let said = [said.covariance[(0, 0)], said.firm_point().1];
            let (mut mean, mut sum) = (Vector2::zeros(), Matrix2::zeros());
            for _ in 0..count {
                let mut noisy = exact.clone();
                noisy.iter_mut().for_each(|ray| ray.range_m += std_m * random.normal());
                let line = Line::fit(&noisy, std_m).unwrap();
                let (s, c) = trig::sin_cos(alpha_rad);
                let across_m = Vector2::new(c, s).dot(&line.firm_point().0.coords) - rho_m;
                let turn_rad = wrap_angle(line.alpha_rad - alpha_rad);
                let error = Vector2::new(turn_rad / said[0].sqrt(), across_m / said[1].sqrt());
                mean += error / f64::from(count);
                sum += error * error.transpose() / f64::from(count);
            }
            let off = (sum - Matrix2::identity()).abs().max();
            assert!(off < 0.05, "off by {off} at ρ = {rho_m}: {sum}");
            assert!(mean.abs().max() < 0.05, "biased by {mean} σ at ρ = {rho_m}");
        }
    }

    #[test]
    fn a_line_is_the_same_from_another_frame() {
        let line = Line::fit(&rays(0.3, 2.0, &[0.0, 0.2, 0.4, 0.9]), 0.02).unwrap();
        let frame = SE2::new(0.4, -0.3, 2.5);
        let moved = line.seen_from(&frame);
        let points = rays(0.3, 2.0, &[-0.5, 0.7]);
        for point in points {
            let there = frame.transform_point(&point.end().into());
            assert!((moved.normal().dot(&there.coords) - moved.rho_m).abs() < 1e-12);
        }
        // The covariance by finite differences of (α, ρ).
        let step = 1e-6;
        let by = |d_alpha: f64, d_rho: f64| {
            let near =
                Line { alpha_rad: line.alpha_rad + d_alpha, rho_m: line.rho_m + d_rho, ..line };
            let there = near.seen_from(&frame);
            Vector2::new(there.alpha_rad - moved.alpha_rad, there.rho_m - moved.rho_m) / step
        };
        let j = Matrix2::from_columns(&[by(step, 0.0), by(0.0, step)]);
        let expected = j * line.covariance * j.transpose();
        assert!((moved.covariance - expected).norm() < 1e-5 * expected.norm());
    }

    #[test]
    fn what_is_no_line_gives_none() {
        assert_eq!(Line::fit(&[], 0.02), None);
        let one = rays(0.0, 2.0, &[0.1]);
        assert_eq!(Line::fit(&one, 0.02), None);
        // The same beam twice: any line through its end.
        assert_eq!(Line::fit(&[one[0], one[0]], 0.02), None);
        // Two beams back to back: the line goes through the origin.
        let mut back = rays(0.0, 2.0, &[0.0, 0.0]);
        back[1].direction = -back[1].direction;
        assert_eq!(Line::fit(&back, 0.02), None);
        let mut broken = rays(0.0, 2.0, &[0.0, 0.1, 0.2]);
        broken[1].range_m = f64::NAN;
        assert_eq!(Line::fit(&broken, 0.02), None);
    }
}
