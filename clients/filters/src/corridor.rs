//! A corridor with doors, as a map has it and as a scan shows it.
//!
//! A door is a stretch of side wall that lies deeper than the rest. From the map
//! that is told by rays straight across; from a scan by the points next to the
//! robot, compared with the line of the wall on that side. Both look at the same
//! stretch, so that what is measured is what is predicted.

use nalgebra::{Point2, Vector2};
use rusty_clients::ClientError;
use rusty_geometry::{World, WorldSpec, trig, wrap_angle};

use crate::Beams;
use crate::lines::{Extraction, Segment};

/// A wall this much deeper than the side is a door, m: half of a recess.
const DEEPER_M: f64 = 0.05;
/// A robot looks at so much of the wall to its left and right, m, half of it
/// ahead.
const STRETCH_M: f64 = 0.5;
/// The fewest points of a stretch that say what it is.
const FEWEST_POINTS: usize = 5;
/// A line farther than this from the direction of the body, rad, is no side wall.
const SIDEWAYS_RAD: f64 = 0.5;

/// A line whose distance is less certain than this, m, cannot be told from one
/// as deep as a door.
const SURE_M: f64 = 0.025;

/// Whether there are doors next to the robot, as far as that can be told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Doors {
    /// To its left.
    pub left: Option<bool>,
    /// To its right.
    pub right: Option<bool>,
}

/// The side walls of a corridor in a scan, body frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sides {
    /// The nearest piece of wall to the left: not a door, which is deeper.
    pub left: Option<Segment>,
    /// The same to the right.
    pub right: Option<Segment>,
}

impl Sides {
    /// Finds them.
    pub fn of_scan(extraction: &Extraction, beams: &Beams, ranges_m: &[f64]) -> Self {
        let segments = extraction.segments(beams, ranges_m);
        let quarter = std::f64::consts::FRAC_PI_2;
        let nearest = |bearing_rad: f64| {
            let beside = segments.iter().filter(|s| {
                let line = &s.line;
                wrap_angle(line.alpha_rad - bearing_rad).abs() < SIDEWAYS_RAD
                    && line.rho_m > 0.0
                    && line.covariance[(1, 1)] < SURE_M * SURE_M
            });
            beside.min_by(|a, b| a.line.rho_m.total_cmp(&b.line.rho_m)).copied()
        };
        Self { left: nearest(quarter), right: nearest(-quarter) }
    }

    /// The doors next to the robot.
    pub fn doors(&self, beams: &Beams, ranges_m: &[f64]) -> Doors {
        let beside = |side: &Option<Segment>| {
            let line = side.as_ref()?.line;
            let normal = line.normal();
            let (mut points, mut deeper_m) = (0, 0.0);
            for end in beams.endpoints(ranges_m).map(|endpoint| endpoint.in_body.coords) {
                let across_m = normal.dot(&end);
                if across_m > 0.0 && normal.perp(&end).abs() <= 0.5 * STRETCH_M {
                    points += 1;
                    deeper_m += across_m - line.rho_m;
                }
            }
            (points >= FEWEST_POINTS).then_some(deeper_m > DEEPER_M * points as f64)
        };
        Doors { left: beside(&self.left), right: beside(&self.right) }
    }
}

/// A corridor along the x axis of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Corridor {
    /// Its western end, world frame, m.
    pub from_x_m: f64,
    /// y of its middle, m.
    pub middle_y_m: f64,
    /// Distance between its side walls, m.
    pub width_m: f64,
    /// Length of a cell, m.
    pub cell_m: f64,
    /// In each cell, west to east: which share of it has a door to the north,
    /// and to the south.
    pub doors: Vec<[f64; 2]>,
}

impl Corridor {
    /// Reads a corridor from a map.
    ///
    /// # Errors
    /// [`ClientError::Unusable`] for a map without a door in a side wall along x,
    /// or without side walls.
    pub fn new(plan: &WorldSpec, cell_m: f64) -> Result<Self, ClientError> {
        let unusable = |what: &str| {
            ClientError::Unusable(format!(
                "the map {:?} {what}; this filter is for a corridor along x with recessed doors, \
                 such as the place \"hallway\"",
                plan.name
            ))
        };
        let world = World::new(plan.clone()).map_err(|e| ClientError::Unusable(e.to_string()))?;
        let [x0, y0, x1, y1] = world.bounds();
        let count = ((x1 - x0) / cell_m).floor();
        if !(1.0..=1e5).contains(&count) {
            return Err(unusable("does not fit into 1 to 100 000 cells"));
        }
        let looks = Looks { world, y_m: 0.5 * (y0 + y1), reach_m: y1 - y0 };
        let cells = 0..count as usize;
        let at = |cell: usize, share: f64| x0 + (cell as f64 + share) * cell_m;
        let face = |up: bool| {
            let all = cells.clone().map(|cell| looks.depth_m(at(cell, 0.5), up));
            all.fold(f64::INFINITY, f64::min)
        };
        let faces = [face(true), face(false)];
        if faces.iter().any(|depth_m| *depth_m >= looks.reach_m) {
            return Err(unusable("has no side walls"));
        }
        let share = |cell: usize, side: usize| {
            let parts = [0.1, 0.3, 0.5, 0.7, 0.9].map(|part| at(cell, part));
            let doors = parts.iter().filter(|x| looks.is_door(**x, side == 0, faces[side]));
            doors.count() as f64 / parts.len() as f64
        };
        let doors: Vec<_> = cells.clone().map(|cell| [share(cell, 0), share(cell, 1)]).collect();
        if doors.iter().flatten().all(|share| *share == 0.0) {
            return Err(unusable("has no door in a side wall"));
        }
        let middle_y_m = looks.y_m + 0.5 * (faces[0] - faces[1]);
        Ok(Self { from_x_m: x0, middle_y_m, width_m: faces[0] + faces[1], cell_m, doors })
    }

    /// x of the middle of a cell, world frame, m.
    pub fn x_m(&self, cell: usize) -> f64 {
        self.from_x_m + (cell as f64 + 0.5) * self.cell_m
    }

    /// p(doors | cell) of a robot that faces east or west, if a look at a wall
    /// errs with probability `error`.
    pub fn likelihood(&self, doors: &Doors, cell: usize, east: bool, error: f64) -> f64 {
        let [north, south] = self.doors[cell];
        let (left, right) = if east { (north, south) } else { (south, north) };
        let of = |seen: Option<bool>, share: f64| {
            let door = error + (1.0 - 2.0 * error) * share;
            seen.map_or(1.0, |seen| if seen { door } else { 1.0 - door })
        };
        of(doors.left, left) * of(doors.right, right)
    }
}

/// Looks straight across a corridor.
struct Looks {
    world: World,
    y_m: f64,
    reach_m: f64,
}

impl Looks {
    fn depth_m(&self, x_m: f64, up: bool) -> f64 {
        let direction = Vector2::new(0.0, if up { 1.0 } else { -1.0 });
        self.world.raycast_dir(Point2::new(x_m, self.y_m), direction, self.reach_m).distance_m
    }

    fn is_door(&self, x_m: f64, up: bool, face_m: f64) -> bool {
        let [from_m, _, to_m, _] = self.world.bounds();
        let along = (0..11).map(|k| x_m + STRETCH_M * (0.1 * f64::from(k) - 0.5));
        let (mut count, mut deeper_m) = (0.0, 0.0);
        // Beyond its ends there is no corridor.
        for x_m in along.filter(|x_m| (from_m..to_m).contains(x_m)) {
            count += 1.0;
            deeper_m += self.depth_m(x_m, up).min(face_m + 1.0) - face_m;
        }
        deeper_m > count * DEEPER_M
    }
}

/// Where between the side walls, and how turned: offset to the left of the
/// middle, m, heading from the corridor's direction, rad, and their variances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Across {
    /// Offset from the middle to the robot's left, m.
    pub left_m: f64,
    /// Heading beyond that of the corridor, counter-clockwise, rad.
    pub turned_rad: f64,
    /// Variance of the offset, m².
    pub left_variance: f64,
    /// Variance of the heading, rad².
    pub turned_variance: f64,
}

impl Across {
    /// What a robot knows before its first scan: nothing but that it is between
    /// the walls and drives along them.
    pub fn anywhere(width_m: f64) -> Self {
        let (left_variance, turned_variance) = (width_m * width_m / 12.0, 0.1);
        Self { left_m: 0.0, turned_rad: 0.0, left_variance, turned_variance }
    }

    /// What the walls of a scan say of it; `None` if none was seen.
    pub fn of_sides(sides: &Sides, width_m: f64) -> Option<Self> {
        let quarter = std::f64::consts::FRAC_PI_2;
        let of = |side: &Segment, bearing_rad: f64, sign: f64| Self {
            left_m: sign * (0.5 * width_m - side.line.rho_m),
            turned_rad: wrap_angle(bearing_rad - side.line.alpha_rad),
            left_variance: side.line.covariance[(1, 1)],
            turned_variance: side.line.covariance[(0, 0)],
        };
        let left = sides.left.as_ref().map(|side| of(side, quarter, 1.0));
        let right = sides.right.as_ref().map(|side| of(side, -quarter, -1.0));
        match (left, right) {
            (Some(left), Some(right)) => Some(left.and(&right)),
            (left, right) => left.or(right),
        }
    }

    /// Two independent measurements of the same, by their variances.
    fn and(&self, other: &Self) -> Self {
        let mean = |a: f64, va: f64, b: f64, vb: f64| {
            let sum = (va + vb).max(f64::MIN_POSITIVE);
            ((a * vb + b * va) / sum, va * vb / sum)
        };
        let (left_m, left_variance) =
            mean(self.left_m, self.left_variance, other.left_m, other.left_variance);
        let (turned_rad, turned_variance) =
            mean(self.turned_rad, self.turned_variance, other.turned_rad, other.turned_variance);
        Self { left_m, turned_rad, left_variance, turned_variance }
    }

    /// Which part of a way of the body is along the corridor, and which to the
    /// left, m.
    pub fn along_and_left_m(&self, way_m: Vector2<f64>) -> [f64; 2] {
        let (s, c) = trig::sin_cos(self.turned_rad);
        [c * way_m.x - s * way_m.y, s * way_m.x + c * way_m.y]
    }
}
