//! The path of a point under a constant twist, and its distance to a wall.
//!
//! Between two poses the constant-twist motion is τ = to ⊟ from. Its path is an
//! arc of at most half a turn (log takes the shorter way round), and it is fixed
//! by the two positions and the heading change Δθ alone: the tangent at the
//! start is the chord turned by −Δθ/2, at the end by +Δθ/2, and the curvature is
//! κ = 2 sin(Δθ/2) / chord (chapter 4, Derivation 2, "what the chord looks
//! like"). A sideways part of τ needs no care: it is in the chord.
//!
//! Neither the centre nor the radius is ever formed, since both run off to
//! infinity as the path straightens. In a frame at the start with x along the
//! tangent, the circle is F(x, y) = y − κ(x² + y²)/2 = 0, whose signed distance
//! from a point is 2F / (1 + √(1 − 2κF)) (V. Pratt, *Direct least-squares fitting
//! of algebraic surfaces*, SIGGRAPH 1987): exact for circles of any size, and for
//! the line they become at κ = 0.

use nalgebra::{Point2, Vector2};

use crate::angle::wrap_angle;
use crate::se2::SE2;
use crate::trig;
use crate::wall::Wall;

/// Chords shorter than this, in metres, count as turning on the spot: the path
/// then stays within half of it of both ends.
const SPOT_M: f64 = 1e-12;

/// An arc of at most half a turn, in the world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionArc {
    start: Point2<f64>,
    end: Point2<f64>,
    /// Unit tangent at the start, and at the end.
    tangents: [Vector2<f64>; 2],
    /// Signed heading change from start to end, radians in (−π, π].
    turn_rad: f64,
    length_m: f64,
    curvature_per_m: f64,
}

impl MotionArc {
    /// The path of the origin of a body frame that moves from `from` to `to`
    /// under the constant twist `to ⊟ from`.
    #[must_use]
    pub fn between(from: &SE2, to: &SE2) -> Self {
        let chord = to.translation() - from.translation();
        let chord_m = length(&chord);
        let turn_rad = wrap_angle(to.theta() - from.theta());
        let half_rad = 0.5 * turn_rad;
        let (s, c) = trig::sin_cos(half_rad);
        let spot = chord_m < SPOT_M;
        let along = if spot { Vector2::x() } else { chord / chord_m };
        Self {
            start: Point2::from(from.translation()),
            end: Point2::from(to.translation()),
            tangents: [
                Vector2::new(c * along.x + s * along.y, c * along.y - s * along.x),
                Vector2::new(c * along.x - s * along.y, c * along.y + s * along.x),
            ],
            turn_rad,
            length_m: if spot { 0.0 } else { chord_m / trig::sinc(half_rad) },
            curvature_per_m: if spot { 0.0 } else { 2.0 * s / chord_m },
        }
    }

    /// Length of the path in metres; 0 for a turn on the spot.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.length_m
    }

    /// The point a `fraction` in [0, 1] of the way along.
    #[must_use]
    pub fn point(&self, fraction: f64) -> Point2<f64> {
        let half_rad = 0.5 * fraction * self.turn_rad;
        let (s, c) = trig::sin_cos(half_rad);
        let t = self.tangents[0];
        let bearing = Vector2::new(c * t.x - s * t.y, s * t.x + c * t.y);
        self.start + bearing * (self.length_m * fraction * trig::sinc(half_rad))
    }

    /// Least distance in metres between the arc and a wall of some length; 0 if
    /// they cross.
    ///
    /// The least distance between two curves is at a crossing, at an end of one
    /// of them, or where both run parallel. All are tried: the arc's ends against
    /// the wall, the wall's ends against the arc, and the one point of the arc
    /// whose tangent is parallel to the wall.
    #[must_use]
    pub fn distance(&self, wall: &Wall) -> f64 {
        let at_ends_m = wall.distance(&self.start).min(wall.distance(&self.end));
        if self.length_m == 0.0 {
            return at_ends_m;
        }
        let span = wall.b - wall.a;
        let along_wall = span / length(&span);
        if self.crosses(wall, &along_wall) {
            return 0.0;
        }
        let mut least_m = at_ends_m;
        for end in [wall.a, wall.b] {
            if self.is_beside(&end) {
                least_m = least_m.min(self.circle_offset(&end).abs());
            }
        }
        match self.point_parallel_to(&along_wall) {
            Some(point) => least_m.min(wall.distance(&point)),
            None => least_m,
        }
    }

    /// Least distance in metres between the arc and a point.
    #[must_use]
    pub fn distance_to_point(&self, point: &Point2<f64>) -> f64 {
        let at_ends_m = length(&(point - self.start)).min(length(&(point - self.end)));
        if self.length_m > 0.0 && self.is_beside(point) {
            at_ends_m.min(self.circle_offset(point).abs())
        } else {
            at_ends_m
        }
    }

    /// Whether the point of the whole circle nearest to `point` belongs to the
    /// arc. For at most half a turn that is the wedge between the normals at the
    /// two ends.
    fn is_beside(&self, point: &Point2<f64>) -> bool {
        (point - self.start).dot(&self.tangents[0]) >= 0.0
            && (point - self.end).dot(&self.tangents[1]) <= 0.0
    }

    /// Signed distance in metres from the whole circle, positive to the left of
    /// the path at the start.
    fn circle_offset(&self, point: &Point2<f64>) -> f64 {
        let from_start = point - self.start;
        let y = cross(&self.tangents[0], &from_start);
        let f = y - 0.5 * self.curvature_per_m * from_start.dot(&from_start);
        // Below zero only by rounding, at the centre of the circle.
        let under_root = (1.0 - 2.0 * self.curvature_per_m * f).max(0.0);
        2.0 * f / (1.0 + under_root.sqrt())
    }

    /// Whether the arc and the wall have a point in common. With h the signed
    /// distance of the start from the wall's line and v the place along that
    /// line from the foot of h, F = 0 is a quadratic in v. Measured from that foot
    /// its discriminant e_y² + κh (2 n_y − κh) keeps its digits both for a path
    /// nearly straight (κ → 0) and for a turn nearly on the spot (κ → ∞). A mere
    /// touch, where it is near zero, is found as a distance near zero instead.
    fn crosses(&self, wall: &Wall, along_wall: &Vector2<f64>) -> bool {
        let to_a = wall.a - self.start;
        let h_m = cross(along_wall, &to_a);
        let normal = Vector2::new(-along_wall.y, along_wall.x);
        // Components along the left normal of the start tangent.
        let (e_y, n_y) = (cross(&self.tangents[0], along_wall), cross(&self.tangents[0], &normal));
        let kappa = self.curvature_per_m;
        let discriminant = e_y * e_y + kappa * h_m * (2.0 * n_y - kappa * h_m);
        if discriminant < 0.0 {
            return false;
        }
        let w = e_y + discriminant.sqrt().copysign(e_y);
        let from_m = to_a.dot(along_wall);
        let to_m = (wall.b - self.start).dot(along_wall);
        // One root by the sum that does not cancel, the other from their product;
        // a vanishing κ or w makes a root infinite or NaN, which is in no range.
        [w / kappa, h_m * (kappa * h_m - 2.0 * n_y) / w]
            .into_iter()
            .filter(|v_m| from_m <= *v_m && *v_m <= to_m)
            .any(|v_m| self.is_beside(&(self.start + normal * h_m + along_wall * v_m)))
    }

    /// The point of the arc where it runs parallel to the unit vector, if any;
    /// at exactly half a turn there may be two, and they are the ends.
    fn point_parallel_to(&self, along_wall: &Vector2<f64>) -> Option<Point2<f64>> {
        let tangent = &self.tangents[0];
        let mut angle_rad = trig::atan2(cross(tangent, along_wall), tangent.dot(along_wall));
        // A wall runs both ways: take the way that the arc turns towards.
        if self.turn_rad > 0.0 && angle_rad < 0.0 {
            angle_rad += core::f64::consts::PI;
        } else if self.turn_rad < 0.0 && angle_rad > 0.0 {
            angle_rad -= core::f64::consts::PI;
        }
        let fraction = angle_rad / self.turn_rad;
        (0.0..=1.0).contains(&fraction).then(|| self.point(fraction))
    }
}

/// The z component of `u × v`.
fn cross(u: &Vector2<f64>, v: &Vector2<f64>) -> f64 {
    u.x * v.y - u.y * v.x
}

/// Length of a vector by correctly rounded operations only.
fn length(v: &Vector2<f64>) -> f64 {
    (v.x * v.x + v.y * v.y).sqrt()
}
