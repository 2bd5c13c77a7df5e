//! Following a way of straight pieces.
//!
//! Source: R. C. Coulter, *Implementation of the pure pursuit path tracking
//! algorithm* (CMU-RI-TR-92-01, 1992): aim at the point of the way that is a fixed
//! distance ahead, and drive the circle that leads there, whose curvature is
//! κ = 2y/d² for an aim at (x, y) in the body frame, d away.
//!
//! Departures, and why: the distance ahead is measured along the way from the
//! point nearest to the robot, so that an aim exists however far off it is; and
//! an aim that is far to the side or behind is turned to on the spot, where the
//! circle would lead through a wall.

use nalgebra::Point2;
use rusty_geometry::{SE2, Twist, trig};

use crate::surroundings::Caution;

/// The aim lies this far ahead on the way, m.
const AHEAD_M: f64 = 0.35;

/// The next point nearest to the robot is looked for so far along, m: more would
/// cut off a way that comes back.
const WINDOW_M: f64 = 1.0;

/// An aim farther to the side than this is turned to on the spot.
const ON_THE_SPOT_RAD: f64 = 0.9;

/// Turn rate on the spot for each radian, 1/s.
const TURN_PER_S: f64 = 2.5;

/// Speed for each metre that is left, 1/s, and the least, m/s: a way ends slowly.
const END_PER_S: f64 = 1.5;
const LEAST_M_S: f64 = 0.08;

/// A way, and how far along it the robot is.
#[derive(Clone, Debug)]
pub struct Pursuit {
    corners: Vec<Point2<f64>>,
    /// Length of the way up to each corner, m.
    along_m: Vec<f64>,
    /// The point of the way nearest to the robot: how far along, m.
    done_m: f64,
}

/// Where to go next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// The point, body frame, m.
    pub in_body: Point2<f64>,
    /// Distance of the robot from the way, m.
    pub off_m: f64,
    /// How much of the way is left, m.
    pub left_m: f64,
}

impl Aim {
    /// Direction of the aim, rad from ahead.
    pub fn bearing_rad(&self) -> f64 {
        trig::atan2(self.in_body.y, self.in_body.x)
    }
}

impl Pursuit {
    /// Of a way with these corners. One without any is at its end where the
    /// robot stands.
    pub fn new(corners: Vec<Point2<f64>>) -> Self {
        let mut along_m = Vec::with_capacity(corners.len());
        let mut sum_m = 0.0;
        for (k, corner) in corners.iter().enumerate() {
            sum_m += k.checked_sub(1).map_or(0.0, |before| (corner - corners[before]).norm());
            along_m.push(sum_m);
        }
        Self { corners, along_m, done_m: 0.0 }
    }

    /// How far along the way the robot is, m.
    pub fn done_m(&self) -> f64 {
        self.done_m
    }

    /// Length of the way, m.
    pub fn length_m(&self) -> f64 {
        self.along_m.last().copied().unwrap_or(0.0)
    }

    /// The point so far along, m.
    fn point(&self, along_m: f64) -> Option<Point2<f64>> {
        let next = self.along_m.partition_point(|a| *a <= along_m);
        let (Some(to), Some(before)) = (self.corners.get(next), next.checked_sub(1)) else {
            return self.corners.last().copied();
        };
        let length_m = self.along_m[next] - self.along_m[before];
        let share = (along_m - self.along_m[before]) / length_m;
        Some(self.corners[before] + (to - self.corners[before]) * share)
    }

    /// Moves on to the point of the way nearest to the robot, never back, and
    /// says where to go; `None` without a way.
    pub fn aim(&mut self, pose_in_world: &SE2) -> Option<Aim> {
        let here = Point2::from(pose_in_world.translation());
        let mut off_m = f64::INFINITY;
        let (first_m, last_m) = (self.done_m, self.done_m + WINDOW_M);
        for k in 1..self.corners.len() {
            if self.along_m[k] < first_m || self.along_m[k - 1] > last_m {
                continue;
            }
            let (from, along) = (self.corners[k - 1], self.corners[k] - self.corners[k - 1]);
            let length_m = self.along_m[k] - self.along_m[k - 1];
            if length_m <= 0.0 {
                continue;
            }
            let nearest_m = (here - from).dot(&along) / length_m;
            let least_m = (first_m - self.along_m[k - 1]).max(0.0);
            let on_it_m = nearest_m.max(least_m).min(length_m);
            let distance_m = (from + along * (on_it_m / length_m) - here).norm();
            if distance_m < off_m {
                (off_m, self.done_m) = (distance_m, self.along_m[k - 1] + on_it_m);
            }
        }
        let aim = self.point(self.done_m + AHEAD_M)?;
        let off_m = if off_m.is_finite() { off_m } else { (aim - here).norm() };
        let in_body = pose_in_world.inverse().transform_point(&aim);
        Some(Aim { in_body, off_m, left_m: self.length_m() - self.done_m })
    }
}

/// The command that leads to the aim.
pub fn pursue(aim: &Aim, caution: &Caution) -> Twist {
    let bearing_rad = aim.bearing_rad();
    let most = caution.turn_rad_s;
    if bearing_rad.abs() > ON_THE_SPOT_RAD {
        let omega_rad_s = (TURN_PER_S * bearing_rad).clamp(-most, most);
        return Twist { v_m_s: 0.0, omega_rad_s };
    }
    on_circle(curvature_to(&aim.in_body), aim.left_m + aim.off_m, caution)
}

/// Curvature of the circle through the robot, along its heading, to a point in the body
/// frame, 1/m.
pub(crate) fn curvature_to(in_body: &Point2<f64>) -> f64 {
    let square = in_body.coords.norm_squared();
    if square > 0.0 { 2.0 * in_body.y / square } else { 0.0 }
}

/// The command forwards on a circle for a robot with `left_m` to go: at most as fast as
/// it may turn.
pub(crate) fn on_circle(curvature_per_m: f64, left_m: f64, caution: &Caution) -> Twist {
    let mut v_m_s = caution.speed_m_s.min(end_speed_m_s(left_m));
    if (curvature_per_m * v_m_s).abs() > caution.turn_rad_s {
        v_m_s = caution.turn_rad_s / curvature_per_m.abs();
    }
    Twist { v_m_s, omega_rad_s: curvature_per_m * v_m_s }
}

/// The greatest speed of a robot with `left_m` to go, m/s.
pub(crate) fn end_speed_m_s(left_m: f64) -> f64 {
    (END_PER_S * left_m).max(LEAST_M_S)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;
    use nalgebra::Vector3;

    const DT_S: f64 = 0.02;

    /// Drives until the way is done; the greatest distance from it after
    /// `settled_m` of it, and the end.
    fn follow(corners: Vec<Point2<f64>>, mut pose: SE2, settled_m: f64) -> (f64, SE2) {
        let mut way = Pursuit::new(corners);
        let caution = Caution::default();
        let mut worst_m: f64 = 0.0;
        for _ in 0..10_000 {
            let aim = way.aim(&pose).unwrap();
            if aim.left_m < 0.05 && aim.off_m < 0.05 {
                return (worst_m, pose);
            }
            if way.done_m() > settled_m {
                worst_m = worst_m.max(aim.off_m);
            }
            let twist = pursue(&aim, &caution);
            pose = pose.boxplus(&(Vector3::new(twist.v_m_s, 0.0, twist.omega_rad_s) * DT_S));
        }
        panic!("it never came to the end: {pose:?}");
    }

    #[test]
    fn from_wherever_it_starts_it_comes_onto_the_way() {
        let mut random = Random::new(4, 1);
        for _ in 0..300 {
            let off = |random: &mut Random| 1.0 - 2.0 * random.uniform();
            let pose = SE2::new(
                0.5 * off(&mut random),
                0.5 * off(&mut random),
                std::f64::consts::PI * off(&mut random),
            );
            let way = vec![Point2::new(0.0, 0.0), Point2::new(4.0, 0.0)];
            let (worst_m, end) = follow(way, pose, 2.5);
            assert!(worst_m < 0.01, "{worst_m} m off from {pose:?}");
            assert!((end.x() - 4.0).abs() < 0.06 && end.theta().abs() < 0.05, "{end:?}");
        }
    }

    #[test]
    fn corners_are_cut_by_no_more_than_the_aim_is_ahead() {
        let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (1.0, 2.5), (3.0, 2.5)];
        let way = corners.map(|(x, y)| Point2::new(x, y)).to_vec();
        let (worst_m, end) = follow(way, SE2::new(0.0, 0.0, 0.0), 0.0);
        assert!(worst_m < 0.5 * AHEAD_M, "{worst_m}");
        assert!((Point2::from(end.translation()) - Point2::new(3.0, 2.5)).norm() < 0.08, "{end:?}");
    }

    #[test]
    fn ways_without_a_length_have_an_end() {
        let pose = SE2::new(1.0, 1.0, 0.3);
        assert!(Pursuit::new(Vec::new()).aim(&pose).is_none());
        let here = Point2::new(1.0, 1.0);
        for corners in [vec![here], vec![here, here]] {
            let aim = Pursuit::new(corners).aim(&pose).unwrap();
            assert_eq!((aim.left_m, aim.off_m), (0.0, 0.0));
            let twist = pursue(&aim, &Caution::default());
            assert!(twist.v_m_s.is_finite() && twist.omega_rad_s == 0.0, "{twist:?}");
        }
    }
}
