//! A small map of some scans, and the pose at which another scan fits it best.
//!
//! Sources: E. Olson, *Real-time correlative scan matching*, ICRA 2009: all poses of a
//! window are scored on a table of how likely a beam ends in a cell, and the scores give
//! the covariance, too (eqs. 3 to 5). W. Hess, D. Kohler, H. Rapp, D. Andor, *Real-time
//! loop closure in 2D LIDAR SLAM*, ICRA 2016, alg. 3: branch and bound finds the best
//! pose of the window exactly; tables of the maxima of 2, 4, … cells bound the scores.
//!
//! Departures, and why:
//! * A cell has the likelihood of the nearest end (a Gaussian), as in a likelihood field,
//!   and not its occupancy: the table of a few scans is made in a millisecond.
//! * What no scan of the map looked at says nothing of an end there, if asked for: a robot
//!   that drives down a corridor always sees some wall that is new, and poses that have the
//!   new ends on the old wall would score more. Such ends are left out of the mean, and the
//!   bounds take them for hits.
//! * An end that other scans looked through is not drawn (`seen_through.rs`). Ends of people
//!   or of wrong beams would fill the free space of ten scans, and any pose would fit.
//! * The distance from the guess costs a little of the score. Along a corridor all poses
//!   score the same, and the guess decides.

use std::collections::BinaryHeap;

use nalgebra::{Matrix2, Matrix3, Point2, Vector2, Vector3};
use rusty_geometry::{SE2, trig};

use self::drawing::Drawing;
use self::seen_through::unrefuted;
use crate::Motion;
use crate::icp::{Laser, Ray};
use crate::pyramid::Pyramid;
use crate::tangent::symmetric;

/// Size of a cell, m.
const CELL_M: f64 = 0.05;
/// Angle between neighbouring poses, rad.
const TURN_RAD: f64 = 0.0125;
/// Ends farther from the middle of the map are left out, m.
const RADIUS_M: f64 = 20.0;
/// Tables: the coarsest has the maxima of 2⁴ × 2⁴ cells.
const LEVELS: usize = 5;
/// Ends of a scan are at least this far apart, m, and at most this many are scored.
const APART_M: f64 = 0.1;
const MOST_ENDS: usize = 150;
/// A scan that has fewer ends than this, and whose ends spread by less than this in some
/// direction, one deviation, m, fits in many places of a window.
const FEW_ENDS: usize = 40;
const BREADTH_M: f64 = 0.75;
/// A wide laser with at least this many beams shows by few ends that there is little to see.
const MANY_BEAMS: usize = 2 * FEW_ENDS;
/// A scan with fewer ends than this does so wherever they are.
const FEWEST_ENDS: usize = 32;
/// The highest likelihood in the table, and the mark of what no scan looked at.
const MOST: u8 = 254;
const UNSEEN: u8 = 255;
/// The part of a score that is lost where the guess ceases to be likely.
const UNLIKELY_COSTS: f64 = 0.2;
/// A pose that scores this much less than the best is e^−½ times as likely. Beams are
/// not independent: the error of a wall is that of all its beams.
const SCORE_STD: f64 = 0.03;
/// A pose with one near it that scores more by as many of these deviations is not the best.
const SLOPE_STD: f64 = 2.0;
/// A pose that scores less than the best one by no more than this is as good.
pub const EQUAL_SCORE: f64 = 0.04;
/// Poses as near to the best as this (m, rad) are not another solution.
const OTHER_M: f64 = 0.4;
const OTHER_RAD: f64 = 0.2;

/// What ends where no scan of a map looked say of a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unseen {
    /// That it is wrong, as ends in free space say.
    Misses,
    /// Nothing.
    LeftOut,
}

/// A table of likelihoods, in the frame of a reference pose.
#[derive(Clone, Debug)]
pub struct Submap {
    /// Indices of the cell in the lower left corner, in cells from the origin.
    corner: [i32; 2],
    table: Pyramid,
}

/// A pose in the frame of the submap, and its score.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The pose of the body.
    pub pose: SE2,
    /// Mean likelihood of its ends, 0 to 1.
    pub score: f64,
}

impl Placement {
    /// Whether it scores at least this much more than another solution, if there is one.
    pub fn leads(&self, other: Option<&Self>, by: f64) -> bool {
        other.is_none_or(|other| other.score <= self.score - by)
    }
}

/// The window of a search, around a guess.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// The guess, frame of the submap.
    pub centre: SE2,
    /// Distance to each side, m.
    pub half_m: f64,
    /// Angle to each side, rad.
    pub half_rad: f64,
    /// Poses up to this distance from the guess are likely, m.
    pub likely_m: f64,
    /// Poses up to this angle from the guess are likely, rad.
    pub likely_rad: f64,
}

/// Poses of a window: 2^`level` offsets in x and y from one on, at one angle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Branch {
    bound: f64,
    level: usize,
    turn: i32,
    offset: [i32; 2],
}

impl Eq for Branch {}

impl Ord for Branch {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let place = |b: &Self| (b.level, b.turn, b.offset);
        self.bound.total_cmp(&other.bound).then_with(|| place(other).cmp(&place(self)))
    }
}

impl PartialOrd for Branch {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Submap {
    /// Draws scans, each with the pose of its body in the frame of the map, without ends
    /// that others of them looked through.
    pub fn new<'a>(
        laser: &Laser,
        scans: impl Iterator<Item = (SE2, &'a [Ray])>,
        unseen: Unseen,
    ) -> Self {
        let scans: Vec<(SE2, &[Ray])> = scans.collect();
        let drawing = Drawing::new(&unrefuted(laser, &scans), unseen);
        let size = drawing.size.map(|cells| cells as usize);
        let table = Pyramid::new(&drawing.cells, size, drawing.beyond, LEVELS);
        Self { corner: drawing.corner, table }
    }

    /// The bound of the scores of a branch.
    fn bound(&self, level: usize, cells: &[[i32; 2]], offset: [i32; 2]) -> f64 {
        let offset = [offset[0] - self.corner[0], offset[1] - self.corner[1]];
        let most = f64::from(MOST) * cells.len().max(1) as f64;
        f64::from(self.table.sum(level, cells, offset)) / most
    }

    /// Mean likelihood of ends in these cells: of those that the map looked at, but of half
    /// of them at least.
    fn mean(&self, cells: &[[i32; 2]], offset: [i32; 2]) -> f64 {
        let (mut sum, mut seen) = (0u32, 0);
        for [x, y] in cells {
            let value =
                self.table.most(0, x + offset[0] - self.corner[0], y + offset[1] - self.corner[1]);
            if value != UNSEEN {
                sum += u32::from(value);
                seen += 1;
            }
        }
        f64::from(sum) / (f64::from(MOST) * seen.max(cells.len().div_ceil(2)).max(1) as f64)
    }

    /// Mean likelihood of the ends of a scan at a pose, 0 to 1.
    pub fn score(&self, rays: &[Ray], pose: &SE2) -> f64 {
        self.mean(&cells(&thinned(rays), pose), [0; 2])
    }

    /// The best pose of the window, to a cell and an angle of the grid, and the best
    /// one that is another solution.
    pub fn search(&self, rays: &[Ray], window: &Window) -> [Option<Placement>; 2] {
        let ends = thinned(rays);
        if ends.is_empty() {
            return [None; 2];
        }
        let most = (window.half_rad / TURN_RAD).ceil() as i32;
        let turns: Vec<Vec<[i32; 2]>> =
            (-most..=most).map(|turn| cells(&ends, &window.at(turn, [0; 2]))).collect();
        let of = |turn: i32| &turns[(turn + most) as usize];
        let half = (window.half_m / CELL_M).ceil() as i32;
        let (top, step) = (LEVELS - 1, 1 << (LEVELS - 1));
        let mut heap = BinaryHeap::new();
        let branch = |level: usize, turn: i32, offset: [i32; 2]| {
            let cost = window.cost(level, turn, offset);
            let scores = match level {
                0 => self.mean(of(turn), offset),
                _ => self.bound(level, of(turn), offset),
            };
            Branch { bound: scores - cost, level, turn, offset }
        };
        for turn in -most..=most {
            for y in (-half..=half).step_by(step) {
                heap.extend((-half..=half).step_by(step).map(|x| branch(top, turn, [x, y])));
            }
        }
        let mut found: [Option<Placement>; 2] = [None; 2];
        while let Some(Branch { level, turn, offset, .. }) = heap.pop() {
            if level == 0 {
                let pose = window.at(turn, offset);
                let placement = Placement { pose, score: self.mean(of(turn), offset) };
                match found[0] {
                    None => found[0] = Some(placement),
                    Some(best) if is_other(&best.pose, &pose) => {
                        found[1] = Some(placement);
                        break;
                    }
                    _ => {}
                }
                continue;
            }
            let half_step = 1 << (level - 1);
            for (dx, dy) in [(0, 0), (half_step, 0), (0, half_step), (half_step, half_step)] {
                let next = [offset[0] + dx, offset[1] + dy];
                let is_in = next[0] <= half && next[1] <= half;
                // What is as near to the best as the whole branch is not looked at.
                if is_in
                    && !found[0]
                        .is_some_and(|best| window.is_near(&best.pose, level - 1, turn, next))
                {
                    heap.push(branch(level - 1, turn, next));
                }
            }
        }
        found
    }

    /// A pose and its covariance, from the scores around a pose that was found. Along a
    /// corridor it is too sure, because ends far away are sparse. `None` where one of these
    /// poses scores far more: the search stopped on a slope, at the edge of what is likely.
    pub fn spread(&self, rays: &[Ray], at: &SE2) -> Option<Motion> {
        let ends = thinned(rays);
        let best = self.mean(&cells(&ends, at), [0; 2]);
        let (mut sum, mut mean, mut square) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for turn in -5..=5 {
            let angle = 0.5 * TURN_RAD * f64::from(turn);
            let cells = cells(&ends, &SE2::new(at.x(), at.y(), at.theta() + angle));
            for y in -5..=5 {
                for x in -5..=5 {
                    let less = (best - self.mean(&cells, [x, y])) / SCORE_STD;
                    if less < -SLOPE_STD {
                        return None;
                    }
                    let weight = trig::exp((-0.5 * less.max(0.0) * less).max(-50.0));
                    let off = Vector3::new(CELL_M * f64::from(x), CELL_M * f64::from(y), angle);
                    sum += weight;
                    mean += off * weight;
                    square += off * off.transpose() * weight;
                }
            }
        }
        let mean = mean / sum;
        let covariance = square / sum - mean * mean.transpose();
        let pose = SE2::new(at.x() + mean.x, at.y() + mean.y, at.theta() + mean.z);
        let own = Vector3::new(0.5 * CELL_M, 0.5 * CELL_M, 0.5 * TURN_RAD);
        let covariance = covariance + Matrix3::from_diagonal(&own.component_mul(&own));
        // From the axes of the map to those of the body.
        let (s, c) = trig::sin_cos(pose.theta());
        let back = Matrix3::new(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0);
        let covariance = symmetric(&(back * covariance * back.transpose()));
        Some(Motion { now_in_then: pose, covariance })
    }
}

impl Window {
    /// A window whose poses are all likely.
    pub fn new(centre: SE2, half_m: f64, half_rad: f64) -> Self {
        Self { centre, half_m, half_rad, likely_m: half_m, likely_rad: half_rad }
    }

    fn at(&self, turn: i32, offset: [i32; 2]) -> SE2 {
        let [x, y] = offset.map(|cells| CELL_M * f64::from(cells));
        let theta = self.centre.theta() + TURN_RAD * f64::from(turn);
        SE2::new(self.centre.x() + x, self.centre.y() + y, theta)
    }

    /// The least that the poses of a branch lose because they are not the guess.
    fn cost(&self, level: usize, turn: i32, offset: [i32; 2]) -> f64 {
        let last = (1 << level) - 1;
        let away = offset.map(|from| f64::from(0.max(from).max(-from - last)) * CELL_M);
        let part_m = (away[0] * away[0] + away[1] * away[1]) / (self.likely_m * self.likely_m);
        let turned = f64::from(turn) * TURN_RAD / self.likely_rad;
        UNLIKELY_COSTS * (part_m + turned * turned)
    }

    /// Whether all poses of a branch are near a pose.
    fn is_near(&self, pose: &SE2, level: usize, turn: i32, offset: [i32; 2]) -> bool {
        let last = (1 << level) - 1;
        let ends = [offset, [offset[0] + last, offset[1] + last]];
        let ends = [ends[0], ends[1], [ends[0][0], ends[1][1]], [ends[1][0], ends[0][1]]];
        ends.iter().all(|end| !is_other(pose, &self.at(turn, *end)))
    }
}

fn is_other(best: &SE2, pose: &SE2) -> bool {
    let apart = best.inverse() * *pose;
    trig::hypot(apart.x(), apart.y()) > OTHER_M || apart.theta().abs() > OTHER_RAD
}

fn cell(at_m: f64) -> i32 {
    (at_m / CELL_M).floor() as i32
}

fn cells(ends: &[Point2<f64>], pose: &SE2) -> Vec<[i32; 2]> {
    let cell_of = |end: &Point2<f64>| {
        let point = pose.transform_point(end);
        [cell(point.x), cell(point.y)]
    };
    ends.iter().map(cell_of).collect()
}

/// Whether a scan shows too little to tell places apart: a piece of one wall, or only what is
/// near. Of a wide laser with few beams no scan is, because they are as few everywhere.
pub fn is_narrow(laser: &Laser, rays: &[Ray]) -> bool {
    let is_told = laser.sees_little() || laser.beams() >= MANY_BEAMS;
    let ends = if is_told { thinned(rays) } else { return false };
    if ends.len() >= FEW_ENDS {
        return false;
    }
    let count = ends.len().max(1) as f64;
    let mean = ends.iter().map(|end| end.coords).sum::<Vector2<f64>>() / count;
    let square = |end: &Point2<f64>| {
        let off = end.coords - mean;
        off * off.transpose()
    };
    let covariance = ends.iter().map(square).sum::<Matrix2<f64>>() / count;
    covariance.symmetric_eigenvalues().min() < BREADTH_M * BREADTH_M
}

/// Whether a scan is too little to be placed by one search: it is narrow, or few beams met
/// something. Then wheels that it does not match are not refuted.
pub fn is_meagre(laser: &Laser, rays: &[Ray]) -> bool {
    rays.len() < FEWEST_ENDS || is_narrow(laser, rays)
}

/// The rays of a scan that count, with ends about evenly along the walls.
pub fn scored(rays: &[Ray]) -> impl Iterator<Item = &Ray> {
    let mut chosen: Vec<&Ray> = Vec::new();
    for ray in rays {
        let is_apart = chosen.last().is_none_or(|last| (last.point - ray.point).norm() >= APART_M);
        if is_apart && ray.point.coords.norm() < RADIUS_M {
            chosen.push(ray);
        }
    }
    let step = 1 + chosen.len() / MOST_ENDS;
    chosen.into_iter().step_by(step)
}

/// Their ends.
fn thinned(rays: &[Ray]) -> Vec<Point2<f64>> {
    scored(rays).map(|ray| ray.point).collect()
}

mod drawing;
mod seen_through;
#[cfg(test)]
mod tests;
