//! Does a moving disc touch a wall anywhere on its way?
//!
//! Source: the online *Probabilistic Robotics*, chapter 4, "The world", which
//! leaves the body of `blocks` open. A test of the two ends only would let a fast
//! robot tunnel through a wall between them; here the whole arc is tested, and
//! exactly, not by samples.

use nalgebra::Point2;

use crate::motion_arc::MotionArc;
use crate::se2::SE2;
use crate::world::World;

/// By how much a wall may miss the reach of the motion, relative to that reach
/// plus one metre, before it is left out unseen: far above rounding, so leaving
/// out never decides.
const CULL_SLACK: f64 = 1e-9;

impl World {
    /// Whether a disc of `radius_m` around the body's origin touches a wall
    /// (comes closer than `radius_m`, or crosses one) anywhere along the
    /// constant-twist motion from `from` to `to`, both ends included.
    ///
    /// - The motion is τ = `to ⊟ from`, so at most half a turn: of a longer turn
    ///   only the shorter equivalent is known. A turn on the spot sweeps nothing
    ///   new; it is blocked exactly if the disc touches where it stands.
    /// - A body that *already* touches is blocked whatever it does, even if it
    ///   moves away; the rule is "any touch along the way". A simulator that
    ///   undoes blocked steps never gets there, and a start pose should be
    ///   checked with `blocks(&start, &start, radius_m)`.
    /// - At exactly `radius_m` the disc does not touch. With radius 0 only a
    ///   crossing counts.
    /// - Poses that are not finite, and a radius that is negative or not finite,
    ///   are blocked: a body that is nowhere cannot move freely.
    ///
    /// Cost: an arc of at most half a turn lies inside the circle over its chord,
    /// so one box query of the tree ends the normal, free step without a single
    /// trigonometric function.
    #[must_use]
    pub fn blocks(&self, from: &SE2, to: &SE2, radius_m: f64) -> bool {
        if !(from.is_finite() && to.is_finite() && radius_m.is_finite() && radius_m >= 0.0) {
            return true;
        }
        let half = (to.translation() - from.translation()) * 0.5;
        let middle = Point2::from(from.translation() + half);
        let reach_m = (half.x * half.x + half.y * half.y).sqrt() + radius_m;
        let reach_m = reach_m + CULL_SLACK * (1.0 + reach_m);
        let mut arc = None;
        self.tree().any_near(&middle, reach_m, |index| {
            let wall = &self.walls()[index];
            if wall.distance(&middle) >= reach_m {
                return false;
            }
            let distance_m = arc.get_or_insert_with(|| MotionArc::between(from, to)).distance(wall);
            distance_m < radius_m || distance_m == 0.0
        })
    }
}
