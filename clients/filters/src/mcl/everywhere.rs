//! Where in a map a scan fits: all places, by branch and bound.
//!
//! Source: W. Hess, D. Kohler, H. Rapp, D. Andor, *Real-time loop closure in 2D LIDAR
//! SLAM*, ICRA 2016, alg. 3, on a blurred likelihood field.
//!
//! Departures, and why:
//! * Not one pose is found but all that fit about as well, each at some distance from the
//!   others: rooms look alike, and later scans decide.
//! * The body has to be in free space.
//! * The field sees through walls (*Probabilistic Robotics*, §6.4): a small room fits whatever
//!   is around the robot, if the walls of others are behind its own. An end is a random one where
//!   a wall is in the way of its beam, and open space behind that wall: beams along a wall
//!   touch its cells. It has to be in the way from the sides of the sensor too: the poses are as far
//!   apart as cells and headings, and doors are narrow. Panes do not count. On a map of cells that
//!   goes for ends where nothing was seen only, which would be as likely as anywhere: such a map
//!   has cells in the way of right beams.

use nalgebra::{Point2, Vector2};
use rusty_geometry::{SE2, Wall, trig};

use super::FreeSpace;
use crate::pyramid::Pyramid;
use crate::ray_walk::RayWalk;
use crate::{GridFrame, LikelihoodField};

/// Number of headings. Neighbouring ones move the end of a beam of 5 m by 0.2 m.
const TURNS: i32 = 160;
/// Tables: the coarsest has the maxima of 2⁵ × 2⁵ cells.
const LEVELS: usize = 6;
/// Two poses this near to each other (m, rad) are one place.
const APART_M: f64 = 0.5;
const APART_RAD: f64 = 0.3;
/// Open space is no nearer than this to a wall, m.
const OPEN_M: f64 = 0.3;
/// A wall is in the way of a beam if it also is in that of beams from both sides of the sensor,
/// this far from it, m.
const ASIDE_M: f64 = 0.2;
/// The most sets of poses that are looked at.
const MOST_BRANCHES: usize = 1 << 20;

/// A place where a scan fits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The pose of the body, world frame.
    pub pose_in_world: SE2,
    /// Mean ln p of a beam.
    pub mean_log: f64,
}

/// All places where a scan fits.
#[derive(Clone, Debug, PartialEq)]
pub struct Fits {
    /// Each at some distance from the others, the best first.
    pub places: Vec<Fit>,
    /// Mean ln p of a beam that no other place exceeds.
    pub others_log: f64,
}

impl Fits {
    /// Adds a place, unless it is one of those that there are.
    pub fn add(&mut self, fit: Fit) {
        if !self.places.iter().any(|place| is_near(&place.pose_in_world, &fit.pose_in_world)) {
            let better = self.places.partition_point(|place| place.mean_log >= fit.mean_log);
            self.places.insert(better, fit);
        }
    }
}

/// Whether two poses are one place.
pub(super) fn is_near(a: &SE2, b: &SE2) -> bool {
    is_within(a, b, APART_M, APART_RAD)
}

/// Whether two poses are no farther apart than this (m, rad).
pub(super) fn is_within(a: &SE2, b: &SE2, most_m: f64, most_rad: f64) -> bool {
    let way = a.inverse().compose(b);
    way.translation().norm() <= most_m && way.theta().abs() <= most_rad
}

/// Poses at one heading: 2^`level` × 2^`level` cells from one on.
#[derive(Clone, Copy, Debug)]
struct Branch {
    level: usize,
    turn: i32,
    offset: [i32; 2],
}

/// Branches that wait, by the bound of their sums.
struct Queue<'a> {
    everywhere: &'a Everywhere,
    /// The cells of the ends at each heading.
    turns: Vec<Vec<[i32; 2]>>,
    /// A part has no greater bound than the whole, so that no bucket above `most` fills again.
    buckets: Vec<Vec<Branch>>,
    most: usize,
}

impl<'a> Queue<'a> {
    /// All poses.
    fn new(everywhere: &'a Everywhere, ends: &[Point2<f64>]) -> Self {
        let turns = (0..TURNS).map(|turn| everywhere.cells(ends, turn)).collect();
        let most = 255 * ends.len();
        let mut queue = Self { everywhere, turns, buckets: vec![Vec::new(); most + 1], most };
        let GridFrame { width, height, .. } = everywhere.frame;
        let (level, step) = (LEVELS - 1, 1 << (LEVELS - 1));
        for y in (0..height as i32).step_by(step) {
            for x in (0..width as i32).step_by(step) {
                (0..TURNS).for_each(|turn| queue.push(Branch { level, turn, offset: [x, y] }));
            }
        }
        queue
    }

    /// Adds a branch, if the body can be in any of its cells.
    fn push(&mut self, branch: Branch) {
        let Branch { level, turn, offset } = branch;
        if self.everywhere.free.most(level, offset[0], offset[1]) > 0 {
            let cells = &self.turns[turn as usize];
            let bound = self.everywhere.scores.sum(level, cells, offset);
            self.buckets[bound as usize].push(branch);
        }
    }

    /// The branch with the greatest bound; of equal ones the newest.
    fn pop(&mut self) -> Option<(u32, Branch)> {
        loop {
            if let Some(branch) = self.buckets[self.most].pop() {
                return Some((self.most as u32, branch));
            }
            self.most = self.most.checked_sub(1)?;
        }
    }
}

/// A map in which a scan is looked up at every pose.
#[derive(Clone, Debug)]
pub struct Everywhere {
    frame: GridFrame,
    scores: Pyramid,
    /// 255 where the body can be, 0 elsewhere.
    free: Pyramid,
    /// Whether a cell has a wall that no beam passes.
    walls: Vec<bool>,
    /// The greatest score of open space.
    open: u8,
    /// The greatest score of an end that a wall makes a random one.
    hidden: u8,
    /// ln p of a score of 0, and of 1 less that.
    logs: [f64; 2],
}

impl Everywhere {
    /// Of a field and the places where the body touches nothing.
    pub fn new(field: &LikelihoodField, space: &FreeSpace) -> Self {
        let (frame, scores, logs) = field.pyramid(LEVELS);
        let mut free = vec![0u8; frame.cells()];
        for centre in space.centres() {
            if let Some(cell) = frame.cell_at(centre) {
                free[cell] = 255;
            }
        }
        let (wall, width) = (field.wall(), frame.width);
        let score = |cell: usize| scores.most(0, (cell % width) as i32, (cell / width) as i32);
        let walls = (0..frame.cells()).map(|cell| score(cell) >= wall).collect();
        // Nothing is beyond a floor plan.
        let hidden = if scores.beyond() == 0 { u8::MAX } else { scores.beyond() };
        let free = Pyramid::new(&free, [frame.width, frame.height], 0, LEVELS);
        Self { frame, scores, free, walls, open: field.open(OPEN_M), hidden, logs }
    }

    /// With panes of glass among its walls. The beams that pass them end behind walls.
    pub fn with_glass(mut self, panes: &[Wall]) -> Self {
        for part in panes.iter().flat_map(|pane| RayWalk::new(&self.frame, pane.a, pane.b)) {
            let (columns, rows) = (part.column - 1..=part.column + 1, part.row - 1..=part.row + 1);
            let around = columns.flat_map(|column| rows.clone().map(move |row| (column, row)));
            for cell in around.filter_map(|(column, row)| self.frame.index(column, row)) {
                self.walls[cell] = false;
            }
        }
        self
    }

    /// How well a scan fits at a pose, on the map or not. `sensor`, where the beams begin, and
    /// `ends` are in the body frame, m.
    pub fn fit(&self, sensor: &Point2<f64>, ends: &[Point2<f64>], pose_in_world: SE2) -> Fit {
        let from = pose_in_world.transform_point(sensor);
        let score = |end: &Point2<f64>| {
            let to = pose_in_world.transform_point(end);
            let score = self.score_at(self.frame.column_row(to));
            let is_random = (1..=self.hidden).contains(&score) && self.is_hidden(from, to);
            if is_random { 0 } else { u32::from(score) }
        };
        let mean_log = self.mean_log(ends.iter().map(score).sum(), ends.len());
        Fit { pose_in_world, mean_log }
    }

    /// Whether a wall and open space behind it are between the two, for a sensor at `from` and
    /// on both sides of it.
    fn is_hidden(&self, from: Point2<f64>, to: Point2<f64>) -> bool {
        let way = to - from;
        let side = Vector2::new(-way.y, way.x) * (ASIDE_M / way.norm());
        [0.0, 1.0, -1.0].iter().all(|&k| self.is_behind_a_wall(from + side * k, to))
    }

    fn is_behind_a_wall(&self, from: Point2<f64>, to: Point2<f64>) -> bool {
        let mut has_met = false;
        RayWalk::new(&self.frame, from, to).any(|part| {
            let cell = self.frame.index(part.column, part.row);
            has_met |= cell.is_some_and(|cell| self.walls[cell]);
            has_met && self.score_at((part.column, part.row)) <= self.open
        })
    }

    fn score_at(&self, (column, row): (i64, i64)) -> u8 {
        let inside = self.frame.index(column, row);
        inside.map_or(self.scores.beyond(), |_| self.scores.most(0, column as i32, row as i32))
    }

    fn pose(&self, turn: i32, [x, y]: [i32; 2]) -> SE2 {
        let at = |cells: i32| self.frame.cell_m * (f64::from(cells) + 0.5);
        let origin = self.frame.origin_m;
        SE2::new(origin.x + at(x), origin.y + at(y), turn_rad(turn))
    }

    /// The places where these ends of beams from `sensor` (body frame, m) fit best: at most
    /// `most`, and none where a beam is less likely than at the best by more than `within` (in
    /// ln p). Ends early, with fewer, where the map is large and much of it alike.
    pub fn best(
        &self,
        sensor: &Point2<f64>,
        ends: &[Point2<f64>],
        most: usize,
        within: f64,
    ) -> Fits {
        let (mut queue, mut found) = (Queue::new(self, ends), Vec::<Branch>::new());
        let mut fits = Fits { places: Vec::new(), others_log: self.logs[0] };
        let mut least_log = f64::NEG_INFINITY;
        for _ in 0..MOST_BRANCHES {
            let Some((bound, branch)) = queue.pop() else { break };
            let log = self.mean_log(bound, ends.len());
            fits.others_log = log;
            if fits.places.len() == most || log < least_log {
                break;
            }
            if found.iter().any(|one| branch.is_near(one, self.frame.cell_m)) {
                continue;
            }
            if branch.level == 0 {
                let pose_in_world = self.pose(branch.turn, branch.offset);
                fits.add(self.fit(sensor, ends, pose_in_world));
                least_log = least_log.max(log - within);
                found.push(branch);
                continue;
            }
            let (level, half) = (branch.level - 1, 1 << (branch.level - 1));
            for (dx, dy) in [(0, 0), (half, 0), (0, half), (half, half)] {
                let offset = [branch.offset[0] + dx, branch.offset[1] + dy];
                queue.push(Branch { level, offset, ..branch });
            }
        }
        fits
    }

    /// Mean ln p of these many ends whose values have this sum.
    fn mean_log(&self, sum: u32, ends: usize) -> f64 {
        self.logs[0] + self.logs[1] * f64::from(sum) / (255.0 * ends.max(1) as f64)
    }

    /// The cells of the ends for a body in the middle of the first cell.
    fn cells(&self, ends: &[Point2<f64>], turn: i32) -> Vec<[i32; 2]> {
        let middle = 0.5 * self.frame.cell_m;
        let pose = SE2::new(middle, middle, turn_rad(turn));
        let cell = |m: f64| (m / self.frame.cell_m).floor() as i32;
        let of = |end: &Point2<f64>| {
            let point = pose.transform_point(end);
            [cell(point.x), cell(point.y)]
        };
        ends.iter().map(of).collect()
    }
}

impl Branch {
    /// Whether all its poses are near the one of another, a cell being so wide (m).
    fn is_near(&self, one: &Self, cell_m: f64) -> bool {
        let last = (1 << self.level) - 1;
        let span = |from: i32, at: i32| f64::from((from - at).abs().max((from + last - at).abs()));
        let [dx, dy] = [0, 1].map(|axis| span(self.offset[axis], one.offset[axis]));
        let turned = (self.turn - one.turn).rem_euclid(TURNS);
        let turned_rad = turn_rad(turned.min(TURNS - turned));
        cell_m * trig::hypot(dx, dy) <= APART_M && turned_rad <= APART_RAD
    }
}

fn turn_rad(turn: i32) -> f64 {
    core::f64::consts::TAU * f64::from(turn) / f64::from(TURNS)
}

#[cfg(test)]
#[path = "everywhere_tests.rs"]
mod tests;
