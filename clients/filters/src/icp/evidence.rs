//! What pairs of points and walls say of a pose: the point-to-line metric to
//! second order, and how sure it is.
//!
//! Source of the covariance: A. Censi, *An accurate closed-form estimate of
//! ICP's covariance*, ICRA 2007: with J the metric, x its minimum and z the
//! ranges of both scans, cov(x) = J_xx⁻¹ J_xz cov(z) J_xzᵀ J_xx⁻¹.
//!
//! Departures, and why:
//! * It is kept as a linear measurement y = H τ + v of the τ with truth =
//!   pose ⊞ τ, where H = J_xx and v has the covariance M = J_xz cov(z) J_xzᵀ.
//!   That has a meaning where H cannot be inverted: a corridor measures nothing
//!   along itself, and a prior then decides there.
//! * J_xz goes through the fitted lines: each ray moves every line that it was
//!   fitted to. Terms with the residual itself are left out (Gauss–Newton).
//! * Errors of the normals give H something in every direction on average, in a
//!   featureless corridor as well. As much as they give is taken off again
//!   (errors in variables; W. Fuller, *Measurement Error Models*, 1987, §1.2), and M has as
//!   much more, because what they gave in this scan is not known. y is corrected likewise: a
//!   line that is too high leans as well, and a point that is too far from its wall is also
//!   farther along it.

use nalgebra::{Matrix3, Point2, Vector2, Vector3};
use rusty_contract::Innovation;
use rusty_geometry::SE2;

use super::SURE_DEVIATIONS;
use super::laser::Ray;
use super::surface::{Nearest, Side, Surface};
use crate::Motion;
use crate::tangent::{at_least_zero, right_jacobian, right_jacobian_inverse, seen_from, symmetric};

/// Two walls face the same way if the cosine of the angle between their normals is at least
/// this, that of 45 degrees.
const SAME_WAY: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// A point and the piece of wall that it lies on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    /// Which ray of the scan now.
    pub(super) ray: usize,
    /// Which piece of the surface.
    pub(super) piece: usize,
    /// How far along it, m.
    pub(super) at_m: f64,
    /// Distance from the line, positive on the sensor's side, m.
    pub(super) residual_m: f64,
    /// Variance of that, m².
    pub(super) variance_m2: f64,
    /// Whether the wall that the scan now has at the point, if it has one, faces the same way.
    pub(super) is_same_way: bool,
}

impl Pair {
    /// Size of the residual in deviations.
    pub(super) fn surprise(&self) -> f64 {
        self.residual_m.abs() / self.variance_m2.sqrt()
    }
}

/// Finds the wall of every ray of the scan now, seen from the body's pose `now` in the frame of
/// the surface.
pub(super) fn pairs(
    surface: &Surface,
    scan: &Surface,
    viewpoint: &Point2<f64>,
    now: &SE2,
    reach_m: f64,
    by: Nearest,
) -> Vec<Pair> {
    let viewpoint = now.transform_point(viewpoint);
    let turn = SE2::new(0.0, 0.0, now.theta());
    let turned = |v: &Vector2<f64>| turn.transform_point(&Point2::from(*v)).coords;
    let of_ray = |(k, ray): (usize, &Ray)| {
        let point = now.transform_point(&ray.point);
        let (piece, at_m) = surface.nearest(&point, &viewpoint, reach_m, Side::Front, by)?;
        let wall = &surface.pieces()[piece];
        let own = scan.piece_of(ray);
        let is_same_way = own.is_none_or(|own| turned(&own.normal).dot(&wall.normal) >= SAME_WAY);
        let direction = turned(&ray.direction);
        let variance_m2 =
            surface.variance_m2(&direction, &wall.normal) + wall.height_variance_m2(at_m);
        let residual_m = (point - wall.middle).dot(&wall.normal);
        Some(Pair { ray: k, piece, at_m, residual_m, variance_m2, is_same_way })
    };
    scan.rays().iter().enumerate().filter_map(of_ray).collect()
}

/// Makes pairs less certain by what is not known of the pose (`covariance` of its τ): the
/// distance of a point from its wall by three deviations, at most by a variance of `most_m2`.
pub(super) fn loosen(
    pairs: &mut [Pair],
    surface: &Surface,
    rays: &[Ray],
    now: &SE2,
    covariance: &Matrix3<f64>,
    most_m2: f64,
) {
    let back = SE2::new(0.0, 0.0, -now.theta());
    for pair in pairs {
        let normal = &surface.pieces()[pair.piece].normal;
        let normal = back.transform_point(&Point2::from(*normal)).coords;
        let row = row(&normal, &rays[pair.ray].point);
        let unknown_m2 = SURE_DEVIATIONS * SURE_DEVIATIONS * (row.transpose() * covariance * row).x;
        pair.variance_m2 += unknown_m2.clamp(0.0, most_m2);
    }
}

/// The linear measurement y = H τ + v of the τ with truth = `at` ⊞ τ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// The pose that τ is counted from: of the body now in the body then.
    pub at: SE2,
    /// H: symmetric, not negative, perhaps singular.
    pub gain: Matrix3<f64>,
    /// y.
    pub measured: Vector3<f64>,
    /// M, the covariance of v.
    pub noise: Matrix3<f64>,
}

/// A prior and a measurement, put together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fused {
    /// What is believed after it.
    pub motion: Motion,
    /// How surprising the measurement was to the prior.
    pub innovation: Innovation,
}

impl From<Motion> for Evidence {
    /// A motion that was measured with this covariance in all directions.
    fn from(measured: Motion) -> Self {
        let information = measured.covariance.try_inverse().unwrap_or_else(Matrix3::zeros);
        let gain = symmetric(&information);
        Self { at: measured.now_in_then, gain, measured: Vector3::zeros(), noise: gain }
    }
}

impl Evidence {
    /// What these pairs say at the pose `at`. With `exactly` the noise goes
    /// through the fitted lines; without it is H, which is what weights by the
    /// inverse variance would give if no two pairs shared a ray.
    pub(super) fn of(
        surface: &Surface,
        rays: &[Ray],
        pairs: &[Pair],
        at: &SE2,
        exactly: bool,
    ) -> Self {
        let back = SE2::new(0.0, 0.0, -at.theta());
        let turned = |v: &Vector2<f64>| back.transform_point(&Point2::from(*v)).coords;
        let (mut gain, mut of_normals) = (Matrix3::zeros(), Matrix3::zeros());
        let (mut measured, mut noise) = (Vector3::zeros(), Matrix3::zeros());
        let mut of_ray = vec![Vector3::zeros(); if exactly { surface.rays().len() } else { 0 }];
        for pair in pairs {
            let (piece, ray) = (&surface.pieces()[pair.piece], &rays[pair.ray]);
            let normal = turned(&piece.normal);
            let row = row(&normal, &ray.point);
            let weight = 1.0 / pair.variance_m2;
            gain += row * row.transpose() * weight;
            measured -= row * (weight * pair.residual_m);
            let wrong = self::row(&turned(&piece.tangent), &ray.point);
            of_normals += wrong * wrong.transpose() * (weight * piece.tilt_variance);
            measured += wrong * (weight * piece.slope_with_height_m(pair.at_m));
            // How the row changes with the range, which is about the heading only.
            let by_range = self::row(&normal, &Point2::from(ray.direction)).z;
            let of_range = weight * surface.range_variance_m2() * by_range;
            of_normals[(2, 2)] += of_range * by_range;
            measured.z += of_range * ray.direction.dot(&normal);
            if exactly {
                let own_m2 = surface.variance_m2(&ray.direction, &normal);
                noise += row * row.transpose() * (weight * weight * own_m2);
                for (k, lever_m) in surface.levers(pair.piece, pair.at_m) {
                    of_ray[k] += row * (weight * lever_m);
                }
            }
        }
        of_ray.iter().for_each(|lever| noise += lever * lever.transpose());
        noise += of_normals;
        if !exactly {
            noise = gain;
        }
        // A direction without any pair has neither gain nor noise: any noise does.
        noise += Matrix3::identity() * (1e-9 * noise.trace() + 1e-9);
        Self { at: *at, gain: at_least_zero(&(gain - of_normals)), measured, noise }
    }

    /// The step from `at` to the most likely pose, with a belief about it.
    pub(super) fn step(&self, prior: &Motion) -> Option<Vector3<f64>> {
        let (mean, covariance) = seen_from(prior, &self.at);
        let inverse = (Matrix3::identity() + self.gain * covariance).try_inverse()?;
        Some(mean + covariance * inverse * (self.measured - self.gain * mean))
    }

    /// The prior after this measurement (the Kalman filter's update, which needs
    /// no inverse of a prior that may be certain). `None` where numbers end.
    pub fn fuse(&self, prior: &Motion) -> Option<Fused> {
        let (mean, covariance) = seen_from(prior, &self.at);
        let surprise = self.measured - self.gain * mean;
        let s = symmetric(&(self.gain * covariance * self.gain + self.noise));
        let inverse = s.cholesky()?.inverse();
        let k = covariance * self.gain * inverse;
        let rest = Matrix3::identity() - k * self.gain;
        let posterior = rest * covariance * rest.transpose() + k * self.noise * k.transpose();
        let tau = mean + k * surprise;
        // The error is counted from `at` so far, and now from where τ leads.
        let jr = right_jacobian(&tau);
        let posterior = jr * posterior * jr.transpose();
        let now_in_then = self.at.boxplus(&tau);
        let nis = (surprise.transpose() * inverse * surprise).x;
        let motion = Motion { now_in_then, covariance: symmetric(&posterior) };
        let is_sane = now_in_then.is_finite() && nis >= 0.0 && motion.covariance.sum().is_finite();
        is_sane.then_some(Fused { motion, innovation: Innovation { nis, degrees: 3 } })
    }

    /// The measurement as a pose z and the information Λ of its error, with
    /// ½ eᵀ Λ e for e = pose ⊟ z: Λ = H M⁻¹ H, and z = `at` ⊞ Λ⁺ H M⁻¹ y. Where
    /// nothing is measured Λ is zero, and z is `at`.
    pub fn constraint(&self) -> Option<(SE2, Matrix3<f64>)> {
        let inverse = self.noise.cholesky()?.inverse();
        let information = symmetric(&(self.gain * inverse * self.gain));
        let damping = Matrix3::identity() * (1e-9 * information.trace() + 1e-12);
        let pulled = self.gain * inverse * self.measured;
        let tau = (information + damping).cholesky()?.solve(&pulled);
        // Λ is that of errors counted from `at` so far, and now from z.
        let j = right_jacobian_inverse(&tau);
        Some((self.at.boxplus(&tau), symmetric(&(j.transpose() * information * j))))
    }
}

/// How the distance of a point (body frame) from a line with this normal (same
/// frame) changes with τ.
fn row(normal: &Vector2<f64>, point: &Point2<f64>) -> Vector3<f64> {
    Vector3::new(normal.x, normal.y, normal.y * point.x - normal.x * point.y)
}
