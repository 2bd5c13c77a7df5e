//! The straight walls of a floor plan, and which of them a piece of wall is.
//!
//! Walls on one line are one line here, whatever they are made of and whether
//! they touch: a laser measures lines, and each line keeps where on it something
//! stands.

use nalgebra::{Matrix2, Matrix2x3, Matrix3, Point2, Vector2};
use rusty_geometry::{SE2, Wall, WorldSpec, trig, wrap_angle};

use crate::lines::Segment;

/// Ends of walls this near to a line are on it, m.
const SAME_LINE_M: f64 = 1e-3;

/// A line of the floor plan, world frame.
#[derive(Clone, Debug, PartialEq)]
pub struct MapLine {
    /// Unit normal n.
    pub normal: Vector2<f64>,
    /// n·p of its points, m.
    pub rho_m: f64,
    /// Where walls stand: from and to, m along the line (the normal turned to the
    /// left), in order and apart.
    pub walls_m: Vec<[f64; 2]>,
}

impl MapLine {
    fn of(wall: &Wall) -> Self {
        let along = (wall.b - wall.a) / wall.length_m();
        let normal = Vector2::new(along.y, -along.x);
        Self { normal, rho_m: normal.dot(&wall.a.coords), walls_m: Vec::new() }
    }

    fn has(&self, point: &Point2<f64>) -> bool {
        (self.normal.dot(&point.coords) - self.rho_m).abs() < SAME_LINE_M
    }

    fn along_m(&self, point: &Point2<f64>) -> f64 {
        self.normal.perp(&point.coords)
    }

    fn add(&mut self, wall: &Wall) {
        let (a, b) = (self.along_m(&wall.a), self.along_m(&wall.b));
        let mut new = [a.min(b), a.max(b)];
        self.walls_m.retain(|old| {
            let apart = old[1] < new[0] - SAME_LINE_M || new[1] + SAME_LINE_M < old[0];
            if !apart {
                new = [new[0].min(old[0]), new[1].max(old[1])];
            }
            apart
        });
        let place = self.walls_m.partition_point(|old| old[0] < new[0]);
        self.walls_m.insert(place, new);
    }

    /// Which share of the way between two points near the line has a wall on it.
    pub fn covered(&self, from: &Point2<f64>, to: &Point2<f64>) -> f64 {
        let (a, b) = (self.along_m(from), self.along_m(to));
        let (low, high) = (a.min(b), a.max(b));
        let common = |wall: &[f64; 2]| (wall[1].min(high) - wall[0].max(low)).max(0.0);
        self.walls_m.iter().map(common).sum::<f64>() / (high - low).max(1e-9)
    }

    /// How `segment` differs from this line if the body is at `pose_in_world` with
    /// covariance `covariance` (of τ, truth = pose ⊞ τ).
    pub fn innovation(
        &self,
        segment: &Segment,
        pose_in_world: &SE2,
        covariance: &Matrix3<f64>,
    ) -> LineInnovation {
        let (s, c) = trig::sin_cos(pose_in_world.theta());
        let turned = |n: &Vector2<f64>| Vector2::new(c * n.x + s * n.y, c * n.y - s * n.x);
        // A wall has two sides; the normal that is nearer to the measured one.
        let side = if turned(&self.normal).dot(&segment.line.normal()) < 0.0 { -1.0 } else { 1.0 };
        let (world, body) = (self.normal * side, turned(&self.normal) * side);
        let alpha_rad = trig::atan2(body.y, body.x);
        let (firm, firm_variance) = segment.line.firm_point();
        let firm_in_world = pose_in_world.transform_point(&firm);
        let nu = Vector2::new(
            wrap_angle(segment.line.alpha_rad - alpha_rad),
            world.dot(&firm_in_world.coords) - self.rho_m * side,
        );
        // The angle of the map's normal is α_w − θ. The point moves with τ by
        // (τ_x − y τ_θ, τ_y + x τ_θ) in the body's axes, and ν by less of that.
        let lever = body.y * firm.x - body.x * firm.y;
        let h = Matrix2x3::new(0.0, 0.0, -1.0, -body.x, -body.y, -lever);
        let r = Matrix2::new(segment.line.covariance[(0, 0)], 0.0, 0.0, firm_variance);
        let s = h * covariance * h.transpose() + r;
        LineInnovation { nu, h, r, s }
    }
}

/// What was measured of a line less what was expected, and all that an update
/// needs.
///
/// Not ρ, the distance of the line from the robot, is compared, but that of the
/// measured line's [firm point](crate::line_fit::Line::firm_point) from the map's.
/// To first order that is the same update: both are measurements of a line, one a
/// linear function of the other. To second order ρ of a short wall far away is
/// always too small when α is wrong (by ρ δα²/2), and this is not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineInnovation {
    /// How far the line is turned from the map's, rad, and how far its firm point
    /// is beyond it, m.
    pub nu: Vector2<f64>,
    /// H: ν is H τ on average, truth = pose ⊞ τ.
    pub h: Matrix2x3<f64>,
    /// R: the covariance of what was measured.
    pub r: Matrix2<f64>,
    /// S = H P Hᵀ + R.
    pub s: Matrix2<f64>,
}

impl LineInnovation {
    /// νᵀ S⁻¹ ν; infinite where S cannot be inverted.
    pub fn nis(&self) -> f64 {
        let inverse = self.s.try_inverse();
        inverse.map_or(f64::INFINITY, |inverse| self.nu.dot(&(inverse * self.nu)))
    }
}

/// The lines of a floor plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineMap {
    /// In the order in which the floor plan first has them.
    pub lines: Vec<MapLine>,
}

/// When a piece of wall is one of the map's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gate {
    /// The largest νᵀ S⁻¹ ν.
    pub nis: f64,
    /// The least share of the piece that must lie where the map has a wall.
    pub covered: f64,
}

impl Gate {
    /// The gate that lets through a right match with this probability: the
    /// quantile of χ² with two degrees, −2 ln(1 − p).
    pub fn of_probability(probability: f64, covered: f64) -> Self {
        Self { nis: -2.0 * trig::ln(1.0 - probability), covered }
    }
}

impl LineMap {
    /// The lines of these walls.
    pub fn new(plan: &WorldSpec) -> Self {
        let mut lines: Vec<MapLine> = Vec::new();
        for wall in plan.to_walls() {
            match lines.iter_mut().find(|line| line.has(&wall.a) && line.has(&wall.b)) {
                Some(line) => line.add(&wall),
                None => {
                    let mut line = MapLine::of(&wall);
                    line.add(&wall);
                    lines.push(line);
                }
            }
        }
        Self { lines }
    }

    /// The one line that `segment` can be, seen from `pose_in_world`; `None` if
    /// there is none, or more than one.
    pub fn match_of(
        &self,
        segment: &Segment,
        pose_in_world: &SE2,
        covariance: &Matrix3<f64>,
        gate: &Gate,
    ) -> Option<&MapLine> {
        let [from, to] = [segment.from, segment.to].map(|p| pose_in_world.transform_point(&p));
        let mut fitting = self.lines.iter().filter(|line| {
            let nis = line.innovation(segment, pose_in_world, covariance).nis();
            nis <= gate.nis && line.covered(&from, &to) >= gate.covered
        });
        let first = fitting.next()?;
        fitting.next().is_none().then_some(first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;
    use crate::line_fit::Line;
    use nalgebra::Vector3;

    /// A piece of the wall through two points, as seen from a pose without error.
    fn seen(a: [f64; 2], b: [f64; 2], pose: &SE2) -> Segment {
        let [a, b] = [a, b].map(|p| pose.inverse().transform_point(&p.into()));
        let along = (b - a).normalize();
        let mut normal = Vector2::new(along.y, -along.x);
        if normal.dot(&a.coords) < 0.0 {
            normal = -normal;
        }
        let covariance = Matrix2::new(4e-4, 1e-4, 1e-4, 3e-4);
        let alpha_rad = trig::atan2(normal.y, normal.x);
        let line = Line { alpha_rad, rho_m: normal.dot(&a.coords), covariance };
        Segment { line, from: a, to: b, points: 20 }
    }

    fn apartment() -> LineMap {
        LineMap::new(rusty_geometry::apartment().spec())
    }

    #[test]
    fn walls_on_one_line_are_one() {
        let map = apartment();
        let of = |normal: [f64; 2], rho_m: f64| {
            let n = Vector2::from(normal);
            let same = |line: &&MapLine| {
                let side = line.normal.dot(&n);
                side.abs() > 0.999 && (line.rho_m * side - rho_m).abs() < 1e-9
            };
            let found: Vec<_> = map.lines.iter().filter(same).collect();
            assert_eq!(found.len(), 1, "{normal:?} {rho_m}");
            let side = found[0].normal.perp(&Vector2::new(-normal[1], normal[0]));
            (found[0].walls_m.clone(), side)
        };
        // Wall, glass and wall; wall, door and wall: each without a gap.
        let (south, _) = of([0.0, 1.0], 0.0);
        assert!(south.len() == 1 && (south[0][1] - south[0][0] - 12.0).abs() < 1e-9, "{south:?}");
        assert_eq!(of([1.0, 0.0], 0.0).0.len(), 1);
        // The corridor's southern wall has two doorways.
        let mut lengths: Vec<f64> =
            of([0.0, 1.0], 3.9).0.iter().map(|wall| wall[1] - wall[0]).collect();
        lengths.sort_by(f64::total_cmp);
        let expected = [0.9, 1.8, 2.5];
        assert!(lengths.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{lengths:?}");
        // x = 0, 2.6, 2.7, 3.6, 7.2, 12 and y = 0, 1.1, 1.2, 3.9, 5.1, 6, 8.3, 9.
        assert_eq!(map.lines.len(), 14);
    }

    #[test]
    fn the_jacobian_is_that_of_the_innovation() {
        let (map, mut random) = (apartment(), Random::new(5, 1));
        let (zero, step) = (Matrix3::zeros(), 1e-6);
        for _ in 0..50 {
            let pose = SE2::new(6.0 * random.uniform(), 8.0 * random.uniform(), random.normal());
            let segment = seen([1.9, 3.9], [4.4, 3.9], &pose);
            let near = pose.boxplus(&Vector3::new(0.02, -0.03, 0.01));
            for line in map.lines.iter().filter(|line| line.has(&Point2::new(3.0, 3.9))) {
                let at = line.innovation(&segment, &near, &zero);
                for i in 0..3 {
                    let mut tau = Vector3::zeros();
                    tau[i] = step;
                    let more = line.innovation(&segment, &near.boxplus(&tau), &zero).nu;
                    let less = line.innovation(&segment, &near.boxplus(&-tau), &zero).nu;
                    // ν(truth) = ν(pose) − H τ.
                    let found = -(more - less) / (2.0 * step);
                    assert!((found - at.h.column(i)).norm() < 1e-8, "{i}: {found} {}", at.h);
                }
                // At the true pose, nothing is surprising.
                let there = line.innovation(&segment, &pose, &zero).nu;
                if line.covered(&Point2::new(2.0, 3.9), &Point2::new(4.0, 3.9)) > 0.9 {
                    assert!(there.norm() < 1e-12, "{there}");
                }
            }
        }
    }

    #[test]
    fn wrong_and_doubtful_walls_are_left_out() {
        let (map, gate) = (apartment(), Gate::of_probability(0.999, 0.75));
        assert!((gate.nis - 13.815_510_558).abs() < 1e-9);
        let pose = SE2::new(3.0, 4.5, 0.3);
        let small = Matrix3::from_diagonal(&Vector3::new(1e-4, 1e-4, 1e-4));
        let found = |segment: &Segment, covariance: &Matrix3<f64>| {
            map.match_of(segment, &pose, covariance, &gate).map(|line| line.rho_m.abs())
        };
        let right = seen([3.0, 3.9], [4.3, 3.9], &pose);
        assert_eq!(found(&right, &small), Some(3.9));
        // A wall where none is, 30 cm next to one.
        assert_eq!(found(&seen([2.0, 4.2], [4.0, 4.2], &pose), &small), None);
        // On the line of one, but in the doorway.
        assert_eq!(found(&seen([0.9, 3.9], [1.9, 3.9], &pose), &small), None);
        // Turned by 20°.
        assert_eq!(found(&seen([2.0, 3.6], [4.0, 4.3], &pose), &small), None);
        // Two lines are near: y = 3.9 and 5.1 from a robot that may be anywhere.
        let lost = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 1e-4));
        assert_eq!(found(&right, &lost), None);
        // Nothing to go by.
        let nothing = LineMap::default();
        assert_eq!(nothing.match_of(&right, &pose, &small, &gate), None);
    }
}
