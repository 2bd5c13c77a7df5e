//! Poses and motions of the plane: the Lie group SE(2).
//!
//! Source: J. Solà, J. Deray, D. Atchuthan, *A micro Lie theory for state
//! estimation in robotics* (arXiv:1812.01537, 2018), appendix on SE(2),
//! eqs. (156)–(158) for exp, log and V(θ), eqs. (25)–(26) for ⊞ and ⊟; K. Lynch
//! and F. Park, *Modern Robotics* (2017), §13.4, eq. (13.35), where the same
//! V(θ)ρ is the odometry update of a differential drive.
//!
//! Departures from both: V(θ) is never formed. Written with half angles it is
//! one factor times one rotation, V(θ) = sinc(θ/2) · R(θ/2): the chord is the
//! arc shortened by sinc(θ/2) and points along half the turn. That form has no
//! cancellation and no singularity for |θ| ≤ π, so it needs no series near zero
//! and exp and log share it (see [`trig::sinc`] for the one switch, at θ = 0).

use core::ops::Mul;

use nalgebra::{Matrix3, Point2, Vector2, Vector3};
use serde::{Deserialize, Serialize};

use crate::angle::wrap_angle;
use crate::trig;

/// A rigid motion of the plane; read as a pose, the place of a body's frame in
/// the world frame: origin `(x, y)` in metres, heading `theta` in radians
/// counter-clockwise from the world x axis, stored in (−π, π].
///
/// Tangent vectors are `Vector3` of (ρ_x m, ρ_y m, θ rad), in the body frame.
///
/// Serialized as `{x_m, y_m, theta_rad}`; reading wraps the angle, which leaves
/// every value this type ever wrote bit for bit as it was.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "PlainPose", into = "PlainPose")]
pub struct SE2 {
    translation_m: Vector2<f64>,
    theta_rad: f64,
}

/// The stored form of [`SE2`], before the angle is wrapped.
#[derive(Serialize, Deserialize)]
#[serde(rename = "SE2", deny_unknown_fields)]
struct PlainPose {
    x_m: f64,
    y_m: f64,
    theta_rad: f64,
}

impl From<PlainPose> for SE2 {
    fn from(plain: PlainPose) -> Self {
        Self::new(plain.x_m, plain.y_m, plain.theta_rad)
    }
}

impl From<SE2> for PlainPose {
    fn from(pose: SE2) -> Self {
        Self { x_m: pose.x(), y_m: pose.y(), theta_rad: pose.theta() }
    }
}

impl SE2 {
    /// The pose at `(x_m, y_m)` with heading `theta_rad`, wrapped to (−π, π].
    ///
    /// Nothing is refused: a NaN stays where it is, see [`SE2::is_finite`].
    #[must_use]
    pub fn new(x_m: f64, y_m: f64, theta_rad: f64) -> Self {
        Self { translation_m: Vector2::new(x_m, y_m), theta_rad: wrap_angle(theta_rad) }
    }

    /// The motion that moves nothing.
    #[must_use]
    pub fn identity() -> Self {
        Self::new(0.0, 0.0, 0.0)
    }

    /// World x of the origin, in metres.
    #[must_use]
    pub fn x(&self) -> f64 {
        self.translation_m.x
    }

    /// World y of the origin, in metres.
    #[must_use]
    pub fn y(&self) -> f64 {
        self.translation_m.y
    }

    /// Heading in radians, in (−π, π].
    #[must_use]
    pub fn theta(&self) -> f64 {
        self.theta_rad
    }

    /// The origin as a vector in the world frame, in metres.
    #[must_use]
    pub fn translation(&self) -> Vector2<f64> {
        self.translation_m
    }

    /// Whether all three numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.x().is_finite() && self.y().is_finite() && self.theta_rad.is_finite()
    }

    /// The motion that the constant twist `tau` = (ρ_x m, ρ_y m, θ rad) makes in
    /// one unit of time (Solà eq. 156): translation sinc(θ/2) · R(θ/2) ρ.
    ///
    /// The translation uses the true θ, however many turns it counts; only the
    /// stored heading is wrapped. Beyond half a turn exp is therefore no longer
    /// one to one, and [`SE2::log`] returns the shorter twist.
    #[must_use]
    pub fn exp(tau: &Vector3<f64>) -> Self {
        let (rho_m, sinc) = half_turn(0.5 * tau.z, Vector2::new(tau.x, tau.y));
        Self { translation_m: rho_m * sinc, theta_rad: wrap_angle(tau.z) }
    }

    /// The shortest constant twist whose [`SE2::exp`] is this motion
    /// (Solà eq. 157): ρ = R(−θ/2) t / sinc(θ/2), θ in (−π, π].
    ///
    /// Never singular: sinc(θ/2) is at least 2/π. At exactly half a turn two
    /// twists are equally short; the one with θ = +π is returned.
    #[must_use]
    pub fn log(&self) -> Vector3<f64> {
        let (chord_m, sinc) = half_turn(-0.5 * self.theta_rad, self.translation_m);
        let rho_m = chord_m / sinc;
        Vector3::new(rho_m.x, rho_m.y, self.theta_rad)
    }

    /// `self ⊞ τ = self ∘ exp(τ)`: move by a twist given in the body frame
    /// (Solà eq. 25).
    #[must_use]
    pub fn boxplus(&self, tau: &Vector3<f64>) -> Self {
        self.compose(&Self::exp(tau))
    }

    /// `self ⊟ other = log(other⁻¹ ∘ self)`: the twist τ, in the frame of
    /// `other`, with `other ⊞ τ = self` (Solà eq. 26).
    ///
    /// The difference of the positions is taken before anything is rotated, so
    /// two near poses far from the origin lose no digits.
    #[must_use]
    pub fn boxminus(&self, other: &Self) -> Vector3<f64> {
        Self {
            translation_m: rotate(-other.theta_rad, self.translation_m - other.translation_m),
            theta_rad: wrap_angle(self.theta_rad - other.theta_rad),
        }
        .log()
    }

    /// `self ∘ other`: first `other`, then `self`. With `self` the pose of a
    /// frame B in A and `other` the pose of C in B, the pose of C in A.
    #[must_use]
    pub fn compose(&self, other: &Self) -> Self {
        self.composed(other, trig::sin_cos(self.theta_rad))
    }

    /// [`compose`](Self::compose) with each of `others`, from one sine and cosine: the
    /// same bits.
    pub fn compose_each(&self, others: &[Self]) -> impl Iterator<Item = Self> {
        let (body, sin_cos) = (*self, trig::sin_cos(self.theta_rad));
        others.iter().map(move |other| body.composed(other, sin_cos))
    }

    fn composed(&self, other: &Self, sin_cos: (f64, f64)) -> Self {
        Self {
            translation_m: self.translation_m + turned(other.translation_m, sin_cos),
            theta_rad: wrap_angle(self.theta_rad + other.theta_rad),
        }
    }

    /// The motion that undoes this one.
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self {
            translation_m: -rotate(-self.theta_rad, self.translation_m),
            theta_rad: wrap_angle(-self.theta_rad),
        }
    }

    /// The adjoint: the matrix Ad with `self ∘ exp(τ) = exp(Ad τ) ∘ self`, for
    /// small and large τ alike (Solà eq. 159). It carries a twist, or the
    /// covariance of one, from the body frame into the frame the pose is in.
    #[must_use]
    pub fn adjoint(&self) -> Matrix3<f64> {
        let (s, c) = trig::sin_cos(self.theta_rad);
        let (x, y) = (self.x(), self.y());
        Matrix3::new(c, -s, y, s, c, -x, 0.0, 0.0, 1.0)
    }

    /// A point given in the body frame, expressed in the world frame (metres).
    #[must_use]
    pub fn transform_point(&self, point_in_body: &Point2<f64>) -> Point2<f64> {
        Point2::from(self.translation_m + rotate(self.theta_rad, point_in_body.coords))
    }
}

impl Default for SE2 {
    fn default() -> Self {
        Self::identity()
    }
}

impl Mul for SE2 {
    type Output = Self;

    /// [`SE2::compose`].
    fn mul(self, other: Self) -> Self {
        self.compose(&other)
    }
}

/// `vector` turned by `angle_rad` counter-clockwise.
fn rotate(angle_rad: f64, vector: Vector2<f64>) -> Vector2<f64> {
    turned(vector, trig::sin_cos(angle_rad))
}

/// [`rotate`] and [`trig::sinc`] of the same angle, from one sine: the same bits.
fn half_turn(half_rad: f64, vector: Vector2<f64>) -> (Vector2<f64>, f64) {
    let sin_cos = trig::sin_cos(half_rad);
    let sinc = if half_rad == 0.0 { 1.0 } else { sin_cos.0 / half_rad };
    (turned(vector, sin_cos), sinc)
}

fn turned(vector: Vector2<f64>, (s, c): (f64, f64)) -> Vector2<f64> {
    Vector2::new(c * vector.x - s * vector.y, s * vector.x + c * vector.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    #[test]
    fn worked_example_of_the_exponential() {
        let pose = SE2::exp(&Vector3::new(0.8, 0.0, 1.0));
        assert!((pose.x() - 0.673_176_788).abs() < 1e-9);
        assert!((pose.y() - 0.367_758_155).abs() < 1e-9);
        let chord_m = trig::hypot(pose.x(), pose.y());
        assert!((0.8 - chord_m - 0.032_919_138).abs() < 1e-9);
        assert!((trig::atan2(pose.y(), pose.x()) - 0.5).abs() < 1e-15);
        let euler_error_m = trig::hypot(pose.x() - 0.8, pose.y());
        assert!((euler_error_m - 0.389_011_810).abs() < 1e-9);
    }

    #[test]
    fn more_than_half_a_turn_moves_by_the_true_angle() {
        let full = SE2::exp(&Vector3::new(1.0, 0.0, 2.0 * PI));
        assert!(trig::hypot(full.x(), full.y()) < 1e-16);
        assert_eq!(full.theta(), 0.0);
        let three_quarters = SE2::exp(&Vector3::new(1.5 * PI, 0.0, 1.5 * PI));
        assert!((three_quarters.x() + 1.0).abs() < 1e-15);
        assert!((three_quarters.y() - 1.0).abs() < 1e-15);
        assert!((three_quarters.theta() + 0.5 * PI).abs() < 1e-15);
    }

    #[test]
    fn json_names_the_units_and_keeps_the_bits() {
        let pose = SE2::new(0.1, -2.0 / 3.0, 3.0);
        let text = serde_json::to_string(&pose).unwrap();
        assert!(text.starts_with(r#"{"x_m":0.1,"y_m":-0.666"#), "{text}");
        assert_eq!(serde_json::from_str::<SE2>(&text).unwrap(), pose);
        let wound: SE2 = serde_json::from_str(r#"{"x_m":0,"y_m":0,"theta_rad":7}"#).unwrap();
        assert_eq!(wound.theta(), 7.0 - 2.0 * PI);
        assert!(serde_json::from_str::<SE2>(r#"{"x_m":0,"y_m":0,"theta_deg":7}"#).is_err());
    }

    #[test]
    fn the_adjoint_carries_twists_across() {
        let pose = SE2::new(1.5, -0.7, 2.2);
        let tau = Vector3::new(0.3, -0.2, 0.4);
        let (right, left) = (pose.boxplus(&tau), SE2::exp(&(pose.adjoint() * tau)) * pose);
        assert!(right.boxminus(&left).norm() < 1e-15, "{right:?} {left:?}");
    }

    #[test]
    fn finite_or_not() {
        assert!(SE2::identity().is_finite());
        assert!(!SE2::new(0.0, 0.0, f64::INFINITY).is_finite());
        assert!(!SE2::new(f64::NAN, 0.0, 0.0).is_finite());
    }
}
