//! A disc: a person, a leg, a post; what a robot and its beams meet next to walls.

use nalgebra::{Point2, Vector2};

use crate::motion_arc::MotionArc;
use crate::se2::SE2;

/// A solid disc in the world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Its centre, m.
    pub centre: Point2<f64>,
    /// Its radius, m.
    pub radius_m: f64,
}

impl Disc {
    /// Distance in metres from `origin` along `unit_dir` to the disc; 0 from inside;
    /// `None` if the ray passes it. `unit_dir` has length 1 up to rounding.
    #[inline]
    #[must_use]
    pub fn cast(&self, origin: &Point2<f64>, unit_dir: &Vector2<f64>) -> Option<f64> {
        let to = self.centre - origin;
        let square = self.radius_m * self.radius_m;
        if to.x * to.x + to.y * to.y <= square {
            return Some(0.0);
        }
        let along = unit_dir.x * to.x + unit_dir.y * to.y;
        let aside = unit_dir.x * to.y - unit_dir.y * to.x;
        let under_root = square - aside * aside;
        (along > 0.0 && under_root >= 0.0).then(|| along - under_root.sqrt())
    }

    /// Whether a disc of `radius_m` touches this one (comes closer than the two radii)
    /// anywhere along the constant-twist motion from `from` to `to`; see
    /// [`World::blocks`](crate::World::blocks).
    #[must_use]
    pub fn blocks(&self, from: &SE2, to: &SE2, radius_m: f64) -> bool {
        let reach_m = radius_m + self.radius_m;
        let half = (to.translation() - from.translation()) * 0.5;
        let middle = Point2::from(from.translation() + half);
        let apart = self.centre - middle;
        let most_m = reach_m + (half.x * half.x + half.y * half.y).sqrt();
        if apart.x * apart.x + apart.y * apart.y > most_m * most_m * (1.0 + 1e-9) {
            return false;
        }
        MotionArc::between(from, to).distance_to_point(&self.centre) < reach_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DISC: Disc = Disc { centre: Point2::new(3.0, 0.5), radius_m: 0.5 };

    #[test]
    fn a_ray_meets_the_near_side() {
        let ahead = Vector2::new(1.0, 0.0);
        assert_eq!(DISC.cast(&Point2::new(0.0, 0.5), &ahead), Some(2.5));
        // Along the rim.
        assert_eq!(DISC.cast(&Point2::new(0.0, 0.0), &ahead), Some(3.0));
        assert_eq!(DISC.cast(&Point2::new(0.0, -0.01), &ahead), None);
        assert_eq!(DISC.cast(&Point2::new(0.0, 0.5), &-ahead), None, "behind");
        assert_eq!(DISC.cast(&Point2::new(3.2, 0.6), &ahead), Some(0.0), "inside");
    }

    #[test]
    fn a_motion_is_blocked_where_it_comes_closer_than_both_radii() {
        let along = |y: f64| (SE2::new(0.0, y, 0.0), SE2::new(6.0, y, 0.0));
        let blocked = |y: f64| {
            let (from, to) = along(y);
            DISC.blocks(&from, &to, 0.2)
        };
        assert!(blocked(0.5) && blocked(1.19) && blocked(-0.19));
        assert!(!blocked(1.21) && !blocked(-0.21));
        // A quarter circle of radius 3 about (0, 3) passes (3, 3) at its end and
        // keeps 0.5 m of clearance from a disc at its centre.
        let (from, to) = (SE2::new(0.0, 0.0, 0.0), SE2::new(3.0, 3.0, std::f64::consts::FRAC_PI_2));
        let at = |x, y, radius_m| Disc { centre: Point2::new(x, y), radius_m };
        assert!(at(0.0, 3.0, 2.9).blocks(&from, &to, 0.2));
        assert!(!at(0.0, 3.0, 2.7).blocks(&from, &to, 0.2));
        assert!(at(2.0, 0.9, 0.1).blocks(&from, &to, 0.2), "on the arc");
        assert!(!at(1.0, 1.0, 0.1).blocks(&from, &to, 0.2), "on the chord");
    }
}
