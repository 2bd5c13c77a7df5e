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
    #[must_use]
    pub fn covered(&self, from: &Point2<f64>, to: &Point2<f64>) -> f64 {
        let (a, b) = (self.along_m(from), self.along_m(to));
        let (low, high) = (a.min(b), a.max(b));
        let common = |wall: &[f64; 2]| (wall[1].min(high) - wall[0].max(low)).max(0.0);
        self.walls_m.iter().map(common).sum::<f64>() / (high - low).max(1e-9)
    }

    /// What `segment` should be if it is on this line and the body is at
    /// `pose_in_world` with covariance `covariance` (of τ, truth = pose ⊞ τ).
    #[must_use]
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
        let rho_m = self.rho_m * side - world.dot(&pose_in_world.translation());
        let nu = Vector2::new(
            wrap_angle(segment.line.alpha_rad - alpha_rad),
            segment.line.rho_m - rho_m,
        );
        // α = α_w − θ and ρ = ρ_w − n_w·t, in a tangent vector at the pose.
        let h = Matrix2x3::new(0.0, 0.0, -1.0, -body.x, -body.y, 0.0);
        let s = h * covariance * h.transpose() + segment.line.covariance;
        LineInnovation { nu, h, s }
    }
}

/// What was measured less what was expected, (rad, m), and all that an update
/// needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineInnovation {
    /// ν = z − h(pose).
    pub nu: Vector2<f64>,
    /// H: how the expectation changes with τ, truth = pose ⊞ τ.
    pub h: Matrix2x3<f64>,
    /// S = H P Hᵀ + R.
    pub s: Matrix2<f64>,
}

impl LineInnovation {
    /// νᵀ S⁻¹ ν; infinite where S cannot be inverted.
    #[must_use]
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
    #[must_use]
    pub fn of_probability(probability: f64, covered: f64) -> Self {
        Self { nis: -2.0 * trig::ln(1.0 - probability), covered }
    }
}

impl LineMap {
    /// The lines of these walls.
    #[must_use]
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
    #[must_use]
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
