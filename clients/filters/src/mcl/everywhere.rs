//! Where in a map a scan fits: all places, by branch and bound.
//!
//! Source: W. Hess, D. Kohler, H. Rapp, D. Andor, *Real-time loop closure in 2D LIDAR
//! SLAM*, ICRA 2016, alg. 3, on a blurred likelihood field.
//!
//! Departures, and why:
//! * Not one pose is found but all that fit about as well, each at some distance from the
//!   others: rooms look alike, and later scans decide.
//! * The body has to be in free space.
//! * The field sees through walls (*Probabilistic Robotics*, §6.4), and what a map of cells
//!   has behind them was not seen, where an end is as likely as anywhere. Not if a wall is in
//!   the way of its beam: such an end is a random one.

use nalgebra::Point2;
use rusty_geometry::{SE2, trig};

use super::FreeSpace;
use crate::pyramid::Pyramid;
use crate::ray_walk::{Crossing, RayWalk};
use crate::{GridFrame, LikelihoodField};

/// Number of headings. Neighbouring ones move the end of a beam of 5 m by 0.2 m.
const TURNS: i32 = 160;
/// Tables: the coarsest has the maxima of 2⁵ × 2⁵ cells.
const LEVELS: usize = 6;
/// Two poses this near to each other (m, rad) are one place.
const APART_M: f64 = 0.5;
const APART_RAD: f64 = 0.3;
/// A wall this near to the end of a beam, m, is the one that it met.
const MET_M: f64 = 0.3;
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
    /// The least score of a cell with a wall.
    wall: u8,
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
        let free = Pyramid::new(&free, [frame.width, frame.height], 0, LEVELS);
        Self { frame, scores, free, wall: field.wall(), logs }
    }

    /// How well a scan fits at a pose, on the map or not. `sensor`, where the beams begin, and
    /// `ends` are in the body frame, m.
    pub fn fit(&self, sensor: &Point2<f64>, ends: &[Point2<f64>], pose_in_world: SE2) -> Fit {
        let from = pose_in_world.transform_point(sensor);
        let unseen = self.scores.beyond();
        let score = |end: &Point2<f64>| {
            let to = pose_in_world.transform_point(end);
            let score = self.score_at(self.frame.column_row(to));
            let is_lost = (1..=unseen).contains(&score) && self.is_hidden(from, to);
            if is_lost { 0 } else { u32::from(score) }
        };
        let mean_log = self.mean_log(ends.iter().map(score).sum(), ends.len());
        Fit { pose_in_world, mean_log }
    }

    /// Whether a wall is between two points.
    fn is_hidden(&self, from: Point2<f64>, to: Point2<f64>) -> bool {
        let last = 1.0 - MET_M / (to - from).norm();
        let way = RayWalk::new(&self.frame, from, to).take_while(|part| part.leaves < last);
        let score = |part: Crossing| self.score_at((part.column, part.row));
        way.map(score).any(|score| score >= self.wall)
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
mod tests {
    use super::*;
    use crate::occupancy::Cell;
    use crate::{BeamModel, Beams, DistanceField, OccupancyMap};
    use rusty_contract::config::LidarConfig;
    use rusty_geometry::{Scan, World};

    const SENSOR: Point2<f64> = Point2::new(0.0, 0.0);

    /// The Apartment in a field of σ = 0.12 m, and the ends of a scan there.
    fn look(truth: &SE2) -> (World, Everywhere, Vec<Point2<f64>>) {
        let (world, lidar) = (rusty_geometry::apartment(), LidarConfig::default());
        let (model, beams) = (BeamModel::of_lidar(&lidar), Beams::new(&lidar));
        let field = LikelihoodField::of_world(&world, &model, beams.range_max_m, 0.12, 0.06);
        let everywhere = Everywhere::new(&field, &FreeSpace::of_world(&world, 0.11));
        let mut scan = Scan::new(lidar.fan());
        scan.take(&world, truth, beams.range_max_m);
        let mut ranges_m = vec![0.0; beams.count()];
        scan.write_distances_m(&mut ranges_m);
        let ends = beams.endpoints(&ranges_m).step_by(3).map(|end| end.in_body).collect();
        (world, everywhere, ends)
    }

    #[test]
    fn the_best_fit_is_that_of_all_poses_and_the_others_fit_worse() {
        for truth in [SE2::new(9.6, 3.0, 0.4), SE2::new(1.6, 6.6, -1.2), SE2::new(6.0, 4.5, 3.0)] {
            let (_, everywhere, ends) = look(&truth);
            let fits = everywhere.best(&SENSOR, &ends, 20, 0.8);
            let GridFrame { width, height, .. } = everywhere.frame;
            let is_near = |pose: &SE2, fit: &Fit| {
                let off = fit.pose_in_world.inverse().compose(pose);
                off.translation().norm() < APART_M + 1e-9 && off.theta().abs() < APART_RAD + 1e-9
            };
            let (mut best, mut other) = (0, 0);
            for turn in 0..TURNS {
                let cells = everywhere.cells(&ends, turn);
                let at = (0..width as i32).flat_map(|x| (0..height as i32).map(move |y| [x, y]));
                for at in at.filter(|at| everywhere.free.most(0, at[0], at[1]) > 0) {
                    let (sum, pose) =
                        (everywhere.scores.sum(0, &cells, at), everywhere.pose(turn, at));
                    best = best.max(sum);
                    if sum > other && !fits.places.iter().any(|fit| is_near(&pose, fit)) {
                        other = sum;
                    }
                }
            }
            let log = |sum: u32| everywhere.mean_log(sum, ends.len());
            assert_eq!(fits.places[0].mean_log, log(best), "{truth:?}");
            assert!(log(other) <= fits.others_log, "{} {fits:?}", log(other));
            assert!(fits.others_log <= fits.places.last().unwrap().mean_log, "{fits:?}");
            let off = truth.inverse().compose(&fits.places[0].pose_in_world);
            assert!(off.translation().norm() < 0.1 && off.theta().abs() < 0.05, "{off:?}");
        }
    }

    #[test]
    fn places_are_apart_and_free_and_their_number_is_limited() {
        let (world, everywhere, ends) = look(&SE2::new(9.6, 3.0, 0.4));
        let fits = everywhere.best(&SENSOR, &ends, 12, 3.0);
        assert_eq!(fits.places.len(), 12);
        for (k, fit) in fits.places.iter().enumerate() {
            let at = Point2::from(fit.pose_in_world.translation());
            assert!(world.distance_to_nearest(at) > 0.11 - 0.08, "{fit:?}");
            for other in &fits.places[..k] {
                let off = other.pose_in_world.inverse().compose(&fit.pose_in_world);
                let is_apart = off.translation().norm() > APART_M || off.theta().abs() > APART_RAD;
                assert!(is_apart && other.mean_log >= fit.mean_log, "{fit:?} {other:?}");
            }
        }
        assert!(
            everywhere.best(&SENSOR, &[], 12, 3.0).places.len() == 12,
            "nothing fits everywhere"
        );
    }

    /// A free room of 3 m × 3 m on a map of 6 m × 6 m; nothing was seen beyond its walls.
    fn room() -> OccupancyMap {
        let frame =
            GridFrame { origin_m: Point2::new(0.0, 0.0), cell_m: 0.05, width: 120, height: 120 };
        let mut map = OccupancyMap::unknown(frame);
        for (column, row) in (30..90).flat_map(|column| (30..90).map(move |row| (column, row))) {
            let is_wall = [column, row].iter().any(|at| [30, 89].contains(at));
            let cell = frame.index(column, row).unwrap();
            map.cells[cell] = if is_wall { Cell::Occupied } else { Cell::Free };
        }
        map
    }

    #[test]
    fn an_end_that_was_not_seen_is_likely_unless_a_wall_hides_it() {
        let map = room();
        let distances = DistanceField::of_map(&map);
        let model = BeamModel::of_lidar(&LidarConfig::default());
        let field = LikelihoodField::of_map(&map, &distances, &model, 8.0, 0.1);
        let everywhere = Everywhere::new(&field, &FreeSpace::of_map(&map, &distances, 0.11));
        let log = |from: [f64; 2], to: [f64; 2]| {
            let [here, end] = [from, to].map(Point2::from);
            let pose = SE2::new(here.x, here.y, 0.0);
            everywhere.fit(&SENSOR, &[end - here.coords], pose).mean_log
        };
        let (random, unseen) = (field.log_at_distance(100.0), -trig::ln(8.0));
        let is = |found: f64, wanted: f64| (found - wanted).abs() < 0.05;
        // Out of the room, from inside and from outside; and on its wall, from both sides.
        assert!(is(log([3.0, 3.0], [3.0, 5.5]), random), "{}", log([3.0, 3.0], [3.0, 5.5]));
        assert!(is(log([0.5, 5.5], [3.0, 5.5]), unseen), "{}", log([0.5, 5.5], [3.0, 5.5]));
        assert!(is(log([-9.0, 50.0], [-5.0, 50.0]), unseen));
        let wall = field.log_at_distance(0.0);
        assert!(is(log([3.0, 3.0], [3.0, 4.475]), wall) && is(log([3.0, 5.5], [3.0, 4.475]), wall));
        // A wall that is nearer to the end than 0.3 m is the one that was met.
        assert!(is(log([3.0, 3.0], [3.0, 4.72]), field.log_at_distance(0.25).max(unseen)));
        // Of one place there is one fit, the better ones first.
        let mut fits = Fits { places: Vec::new(), others_log: random };
        for (x_m, mean_log) in [(1.0, -1.0), (1.3, -0.5), (3.0, -0.7), (5.0, -2.0)] {
            fits.add(Fit { pose_in_world: SE2::new(x_m, 0.0, 0.0), mean_log });
        }
        let found: Vec<f64> = fits.places.iter().map(|fit| fit.mean_log).collect();
        assert_eq!(found, [-0.7, -1.0, -2.0]);
    }
}
