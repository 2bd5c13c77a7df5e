//! Following a curve of arcs and straight pieces, forwards and in reverse.
//!
//! Source: R. C. Coulter, *Implementation of the pure pursuit path tracking
//! algorithm* (CMU-RI-TR-92-01, 1992), as [`crate::pursuit`]: the circle to an aim at
//! (x, y) in the body frame, d away, has the curvature κ = 2y/d², and in reverse the same
//! circle is driven backwards.
//!
//! Departures, and why:
//! * The robot never turns on the spot, and no circle is narrower than its least radius.
//! * A curve is followed one stretch of a direction after the other. The aim of a stretch
//!   may lie beyond its end, on the tangent there, so that the robot comes to the end
//!   with the heading of the curve.

use nalgebra::Point2;
use rusty_geometry::{SE2, Twist};

use crate::planning::curve::Curve;
use crate::pursuit::{curvature_to, on_circle};
use crate::surroundings::Caution;

/// The aim lies this far ahead on the curve, m.
const AHEAD_M: f64 = 0.08;

/// The point of the curve nearest to the robot is looked for so far along, m.
const WINDOW_M: f64 = 0.5;

/// Distance of the poses of a curve, m.
const STEP_M: f64 = 0.01;

/// A part of a curve that is driven in one direction.
#[derive(Clone, Debug)]
struct Stretch {
    /// Poses, world frame, and how far along the stretch they are, m.
    poses: Vec<(f64, SE2)>,
    is_reverse: bool,
}

impl Stretch {
    fn length_m(&self) -> f64 {
        self.poses.last().map_or(0.0, |(along_m, _)| *along_m)
    }

    /// The point so far along; beyond the end on the tangent there.
    fn point(&self, along_m: f64) -> Point2<f64> {
        let next = self.poses.partition_point(|(at_m, _)| *at_m < along_m);
        let (at_m, pose) = self.poses[next.min(self.poses.len() - 1)];
        let beyond_m = (along_m - at_m).max(0.0);
        pose.transform_point(&Point2::new(if self.is_reverse { -beyond_m } else { beyond_m }, 0.0))
    }
}

/// A curve, and how far along it the robot is.
#[derive(Clone, Debug)]
pub struct CurvePursuit {
    stretches: Vec<Stretch>,
    most_per_m: f64,
    /// The stretch that is driven, how far along it, and the length of those before, m.
    current: usize,
    along_m: f64,
    before_m: f64,
}

/// Where to go next on a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveAim {
    /// The point, body frame, m.
    pub in_body: Point2<f64>,
    /// Whether it is driven to in reverse.
    pub is_reverse: bool,
    /// Distance of the robot from the curve, m.
    pub off_m: f64,
    /// How much is left of the stretch, m.
    pub left_m: f64,
    /// The greatest curvature, 1/m.
    pub most_per_m: f64,
}

impl CurvePursuit {
    /// Of a curve, for a robot that can turn on circles of `radius_m` or more.
    pub fn new(curve: &Curve, radius_m: f64) -> Self {
        let mut stretches: Vec<Stretch> = Vec::new();
        let mut pose = curve.from;
        for piece in &curve.pieces {
            let is_reverse = piece.length_m < 0.0;
            if stretches.last().is_none_or(|last| last.is_reverse != is_reverse) {
                stretches.push(Stretch { poses: vec![(0.0, pose)], is_reverse });
            }
            let poses = &mut stretches.last_mut().expect("one was pushed").poses;
            let start_m = poses[poses.len() - 1].0;
            let motions: Vec<SE2> = piece.motions(STEP_M).collect();
            let step_m = piece.length_m.abs() / motions.len() as f64;
            let along = |(k, motion): (usize, &SE2)| {
                (start_m + step_m * (k + 1) as f64, pose.compose(motion))
            };
            poses.extend(motions.iter().enumerate().map(along));
            pose = pose.compose(&piece.motion(1.0));
        }
        let most_per_m = 1.0 / radius_m;
        Self { stretches, most_per_m, current: 0, along_m: 0.0, before_m: 0.0 }
    }

    /// How far along the curve the robot is, m.
    pub fn done_m(&self) -> f64 {
        self.before_m + self.along_m
    }

    /// Moves on to the point nearest to the robot, never back, and says where to go;
    /// `None` at the end.
    pub fn aim(&mut self, world_from_robot: &SE2) -> Option<CurveAim> {
        while let Some(stretch) = self.stretches.get(self.current) {
            let here = Point2::from(world_from_robot.translation());
            let within =
                |(at_m, _): &&(f64, SE2)| (self.along_m..=self.along_m + WINDOW_M).contains(at_m);
            let off = |(at_m, pose): &(f64, SE2)| {
                ((Point2::from(pose.translation()) - here).norm(), *at_m)
            };
            let near = stretch.poses.iter().filter(within).map(off);
            let (off_m, at_m) = near.min_by(|a, b| a.0.total_cmp(&b.0))?;
            self.along_m = at_m;
            let left_m = stretch.length_m() - at_m;
            if left_m > 0.0 {
                let aim = stretch.point(at_m + AHEAD_M);
                let in_body = world_from_robot.inverse().transform_point(&aim);
                let (is_reverse, most_per_m) = (stretch.is_reverse, self.most_per_m);
                return Some(CurveAim { in_body, is_reverse, off_m, left_m, most_per_m });
            }
            self.before_m += stretch.length_m();
            (self.current, self.along_m) = (self.current + 1, 0.0);
        }
        None
    }
}

/// The command that leads to the aim on a circle that the robot can drive.
pub fn pursue_curve(aim: &CurveAim, caution: &Caution) -> Twist {
    let most_per_m = aim.most_per_m;
    let curvature_per_m = curvature_to(&aim.in_body).clamp(-most_per_m, most_per_m);
    let Twist { v_m_s, omega_rad_s } = on_circle(curvature_per_m, aim.left_m, caution);
    let side = if aim.is_reverse { -1.0 } else { 1.0 };
    Twist { v_m_s: side * v_m_s, omega_rad_s: side * omega_rad_s }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;
    use crate::planning::reeds_shepp::reeds_shepp;
    use nalgebra::Vector3;

    const RADIUS_M: f64 = 0.3;

    /// Drives a curve from a pose near its start: the greatest distance from it, and the
    /// end.
    fn follow(curve: &Curve, mut pose: SE2) -> (f64, SE2) {
        let mut way = CurvePursuit::new(curve, 0.9 * RADIUS_M);
        let mut worst_m: f64 = 0.0;
        for _ in 0..10_000 {
            let Some(aim) = way.aim(&pose) else { return (worst_m, pose) };
            worst_m = worst_m.max(aim.off_m);
            let twist = pursue_curve(&aim, &Caution::default());
            assert!(twist.omega_rad_s.abs() <= (twist.v_m_s / (0.9 * RADIUS_M)).abs() + 1e-12);
            assert!(twist.v_m_s != 0.0, "{aim:?}");
            pose = pose.boxplus(&(Vector3::new(twist.v_m_s, 0.0, twist.omega_rad_s) * 0.02));
        }
        panic!("it never came to the end: {pose:?}");
    }

    #[test]
    fn curves_to_anywhere_are_followed_to_their_end_with_its_heading() {
        let mut random = Random::new(8, 1);
        let mut reversed = 0;
        for _ in 0..500 {
            let mut off = |most: f64| most * (1.0 - 2.0 * random.uniform());
            let goal = SE2::new(off(1.5), off(1.5), off(3.1));
            let curve = reeds_shepp(&SE2::identity(), &goal, RADIUS_M);
            reversed += u32::from(curve.pieces.iter().any(|piece| piece.length_m < 0.0));
            let (worst_m, end) = follow(&curve, SE2::new(off(0.01), off(0.01), off(0.02)));
            let missed = end.boxminus(&goal);
            assert!(worst_m < 0.04, "{worst_m} m off the curve to {goal:?}");
            assert!(missed.xy().norm() < 0.03 && missed.z.abs() < 0.15, "{missed:?} to {goal:?}");
        }
        assert!(reversed > 200, "{reversed}");
    }

    #[test]
    fn a_curve_without_pieces_has_an_end() {
        let curve = Curve::new(SE2::new(1.0, 1.0, 0.3), []);
        let mut way = CurvePursuit::new(&curve, RADIUS_M);
        assert_eq!((way.aim(&curve.from), way.done_m()), (None, 0.0));
    }
}
