//! What a filter believes of the ends of beams: the likelihood field.
//!
//! Source: *Probabilistic Robotics*, §6.4, Table 6.3. A reading is the better,
//! the nearer its end lies to an obstacle of the map:
//! p = z_hit · N(d; 0, σ) + z_rand / z_max, with d from a distance field. Readings
//! of z_max say nothing and are left out. An end in a part of the map that no scan
//! has seen has the probability 1 / z_max (§6.4, towards its end).
//!
//! Departures, and why:
//! * The logarithm of p is kept for every cell, so that a scan is a sum, and in a
//!   byte, so that all of a building stays in the processor's own memory: ln p is
//!   `base_log` plus a number of steps of `step_log`, 255 of which lead from the
//!   worst to the best. The sum of a scan is a sum of whole numbers, so it does
//!   not depend on the order in which it is taken.
//! * Between the centres of cells ln p is interpolated. A tracked robot's
//!   particles are millimetres apart; if all within a cell were alike, the sum over
//!   180 beams would be a rugged thing at that scale, by several units of ln p.
//! * A map of cells is itself wrong by about a cell: its side is a σ that is added
//!   to the laser's, as squares are. The same goes for a floor plan so large that
//!   its cells have to be larger than they were wanted (over four million).
//! * What is in front of the map, *short* of the beam model, has no place in
//!   Table 6.3; it is as inexplicable here as *rand* and counted with that. The
//!   mixture is that of readings below z_max, so its weights are divided by
//!   1 − z_max.
//! * An end that was not seen is as likely as if it had been, where that is more: the far side
//!   of every wall is unseen, and half of the readings of a wall end there.
//! * Beyond the map is nothing where it is a floor plan, and what no scan has seen
//!   where it was drawn from scans.
//!
//! Beams next to each other are wrong in the same way wherever the map is, and
//! p as a product over beams does not know that (§6.3.4). Two remedies of the
//! book are the caller's: to take only every so-manieth beam, and to raise the
//! product to a power below 1.

mod view;

use core::f64::consts::PI;

use nalgebra::{Point2, Vector2};
use rusty_geometry::{SE2, World, trig};

use self::view::{PARTS, TOGETHER, View, cut};
use crate::distance_field::DistanceField;
use crate::occupancy::Cell;
use crate::pyramid::Pyramid;
use crate::{BeamModel, GridFrame, OccupancyMap};

/// The most cells of a field that is free to choose them.
const MOST_CELLS: usize = 1 << 22;

/// Cells around the field that are no part of it: between two of them nothing of
/// it is seen.
const BORDER: usize = 2;

/// ln p of the end of a beam, for every cell of a grid.
#[derive(Clone, Debug)]
pub struct LikelihoodField {
    frame: GridFrame,
    /// Steps above the worst, row by row, with a border of two cells that stand
    /// for all beyond.
    steps: Vec<u8>,
    stride: usize,
    /// Steps of a part that no scan has seen.
    unseen: u8,
    /// ln p of no steps.
    base_log: f64,
    /// What a step adds to ln p.
    step_log: f64,
    mixture: Mixture,
}

/// p of a distance.
#[derive(Clone, Copy, Debug)]
struct Mixture {
    peak: f64,
    floor: f64,
    sigma_m: f64,
}

impl Mixture {
    fn new(model: &BeamModel, sigma_m: f64, range_max_m: f64) -> Self {
        // Of the readings that are not z_max.
        let below = (model.z_hit + model.z_short + model.z_rand).max(f64::MIN_POSITIVE);
        // What is in front of the map is as inexplicable here as the rest.
        let strange = (model.z_short + model.z_rand) / below;
        let peak = model.z_hit / below / ((2.0 * PI).sqrt() * sigma_m);
        Self { peak, floor: strange.max(1e-6) / range_max_m, sigma_m }
    }

    fn density(&self, distance_m: f64) -> f64 {
        let z = distance_m / self.sigma_m;
        self.peak * trig::exp(-0.5 * z * z) + self.floor
    }
}

/// The ends of a scan's beams in the body frame, as the lookup takes them.
#[derive(Clone, Debug, Default)]
pub struct Ends {
    x_m: Vec<f32>,
    y_m: Vec<f32>,
    count: usize,
}

impl Ends {
    /// Forgets all, and takes these instead, m.
    pub fn set(&mut self, in_body: impl Iterator<Item = Point2<f64>>) {
        self.x_m.clear();
        self.y_m.clear();
        for point in in_body {
            self.x_m.push(point.x as f32);
            self.y_m.push(point.y as f32);
        }
        self.count = self.x_m.len();
        // Filled up to whole blocks; what is read there is not counted.
        let whole = self.count.next_multiple_of(TOGETHER);
        self.x_m.resize(whole, 0.0);
        self.y_m.resize(whole, 0.0);
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Root of their mean squared distance from the body, m; 0 of none.
    pub fn rms_m(&self) -> f64 {
        let ends = self.x_m.iter().zip(&self.y_m).take(self.count);
        let sum: f64 = ends.map(|(x, y)| f64::from(*x * *x + *y * *y)).sum();
        if self.count == 0 { 0.0 } else { (sum / self.count as f64).sqrt() }
    }
}

impl LikelihoodField {
    /// The field of a floor plan, in cells of `cell_m` (larger ones, and blurred
    /// by as much, where these would be too many), and with `blur_m` of doubt
    /// about where the ends are compared with the laser's own σ.
    pub fn of_world(
        world: &World,
        model: &BeamModel,
        range_max_m: f64,
        blur_m: f64,
        cell_m: f64,
    ) -> Self {
        let mut sigma_m = joint(&[model.sigma_hit_m, blur_m]);
        let mut frame = GridFrame::covering(world.bounds(), 4.0 * sigma_m, cell_m);
        while frame.cells() > MOST_CELLS {
            let coarse_m = 2.0 * frame.cell_m;
            sigma_m = joint(&[model.sigma_hit_m, blur_m, coarse_m]);
            frame = GridFrame::covering(world.bounds(), 4.0 * sigma_m, coarse_m);
        }
        let field = DistanceField::of_world(world, frame);
        Self::of_distances(&field, model, sigma_m, range_max_m, |_| false, false)
    }

    /// The field of a map of cells, on those cells.
    pub fn of_map(
        map: &OccupancyMap,
        distances: &DistanceField,
        model: &BeamModel,
        range_max_m: f64,
        blur_m: f64,
    ) -> Self {
        let sigma_m = joint(&[model.sigma_hit_m, blur_m, map.frame.cell_m]);
        let unseen = |cell: usize| map.cells[cell] == Cell::Unknown;
        Self::of_distances(distances, model, sigma_m, range_max_m, unseen, true)
    }

    fn of_distances(
        field: &DistanceField,
        model: &BeamModel,
        sigma_m: f64,
        range_max_m: f64,
        unseen: impl Fn(usize) -> bool,
        unseen_beyond: bool,
    ) -> Self {
        let mixture = Mixture::new(model, sigma_m, range_max_m);
        let (worst, best) = (trig::ln(mixture.floor), trig::ln(mixture.density(0.0)));
        let (base_log, step_log) = (worst, (best - worst).max(1e-9) / 255.0);
        let steps_of = |log: f64| ((log - base_log) / step_log).round() as u8;
        let unseen_steps = steps_of(-trig::ln(range_max_m));
        let beyond = if unseen_beyond { unseen_steps } else { 0 };
        let stride = field.frame.width + 2 * BORDER;
        let mut steps = vec![beyond; stride * (field.frame.height + 2 * BORDER)];
        for (cell, distance_m) in field.distances_m.iter().enumerate() {
            let (column, row) = (cell % field.frame.width, cell / field.frame.width);
            let by_distance = steps_of(trig::ln(mixture.density(f64::from(*distance_m))));
            let least = if unseen(cell) { unseen_steps } else { 0 };
            steps[(row + BORDER) * stride + column + BORDER] = by_distance.max(least);
        }
        let (frame, unseen) = (field.frame, unseen_steps);
        Self { frame, steps, stride, unseen, base_log, step_log, mixture }
    }

    /// σ of a hit in this field, m.
    pub fn sigma_m(&self) -> f64 {
        self.mixture.sigma_m
    }

    /// ln p of an end at this distance from an obstacle, before it was made a
    /// number of steps.
    pub fn log_at_distance(&self, distance_m: f64) -> f64 {
        trig::ln(self.mixture.density(distance_m))
    }

    /// The least value of a cell that a wall goes through: its middle is no farther from the
    /// wall than half of its diagonal.
    pub(crate) fn wall(&self) -> u8 {
        self.value(0.5 * self.frame.cell_m * core::f64::consts::SQRT_2)
    }

    /// The greatest value of a cell that is this far from all walls, m, or was not seen.
    pub(crate) fn open(&self, distance_m: f64) -> u8 {
        self.unseen.max(self.value(distance_m))
    }

    /// The value of a cell that was seen, at this distance from an obstacle, rounded down.
    fn value(&self, distance_m: f64) -> u8 {
        ((self.log_at_distance(distance_m) - self.base_log) / self.step_log) as u8
    }

    /// Where its cells lie, their values with bounds, and ln p of the values 0 and 255 (as the
    /// difference from that of 0).
    pub(crate) fn pyramid(&self, levels: usize) -> (GridFrame, Pyramid, [f64; 2]) {
        let GridFrame { width, height, .. } = self.frame;
        let rows = self.steps.chunks(self.stride).skip(BORDER).take(height);
        let table: Vec<u8> = rows.flat_map(|row| &row[BORDER..BORDER + width]).copied().collect();
        // The border has the value of all beyond.
        let pyramid = Pyramid::new(&table, [width, height], self.steps[0], levels);
        (self.frame, pyramid, [self.base_log, 255.0 * self.step_log])
    }

    /// What ln p of a beam is on average at the right pose: hits are normal with
    /// σ, the rest lies anywhere.
    pub fn expected_log(&self) -> f64 {
        let (count, mut sum, mut mass) = (400, 0.0, 0.0);
        for k in 0..count {
            let z = 5.0 * (f64::from(k) + 0.5) / f64::from(count);
            let weight = trig::exp(-0.5 * z * z);
            sum += weight * self.log_at_distance(z * self.mixture.sigma_m);
            mass += weight;
        }
        let hits = self.mixture.peak * (2.0 * PI).sqrt() * self.mixture.sigma_m;
        hits * sum / mass + (1.0 - hits) * self.base_log
    }

    /// Σ ln p over the ends of a scan, seen from a body at `pose`.
    pub fn log_likelihood(&self, ends: &Ends, pose: &SE2) -> f64 {
        let (s, c) = trig::sin_cos(pose.theta());
        self.log_of_steps(self.steps_of_scan(ends, &pose.translation(), s, c), ends.count())
    }

    /// ln p of `count` ends whose sum is this many 256ths of a step.
    pub fn log_of_steps(&self, steps: u32, count: usize) -> f64 {
        self.base_log * count as f64 + self.step_log / f64::from(PARTS) * f64::from(steps)
    }

    /// The steps of all ends together, in parts of 256, seen from a body at `position` (m) with
    /// this sine and cosine of its heading.
    pub fn steps_of_scan(&self, ends: &Ends, position: &Vector2<f64>, sin: f64, cos: f64) -> u32 {
        let mut sum = 0_u32;
        self.visit(ends, position, sin, cos, |steps| sum += steps);
        sum
    }

    /// How many ends are within two deviations of a wall, seen from a body at `pose`.
    pub fn on_walls(&self, ends: &Ends, pose: &SE2) -> usize {
        let least = self.least_on_wall();
        let (sin, cos) = trig::sin_cos(pose.theta());
        let mut count = 0;
        let take = |steps| count += usize::from(steps >= least);
        self.visit(ends, &pose.translation(), sin, cos, take);
        count
    }

    /// Whether a beam from `from` to `to` (world frame, m) met something in front of all walls:
    /// no part of it is near one, or unseen.
    pub fn is_in_front(&self, from: &Point2<f64>, to: &Point2<f64>) -> bool {
        let least = self.least_on_wall().min(u32::from(self.unseen) * PARTS);
        let way = to - from;
        let parts = (way.norm() / self.sigma_m()).ceil().max(1.0);
        let is_free = |k: u32| self.steps_at(&(from + way * (f64::from(k) / parts))) < least;
        // Its end first: that of most beams is on a wall.
        (1..=parts as u32).rev().all(is_free)
    }

    /// Steps within two deviations of a wall, in parts of 256.
    fn least_on_wall(&self) -> u32 {
        let log = self.log_at_distance(2.0 * self.sigma_m());
        ((log - self.base_log) / self.step_log * f64::from(PARTS)) as u32
    }

    /// The steps of an end at a point, in parts of 256.
    fn steps_at(&self, point: &Point2<f64>) -> u32 {
        let view = self.view(&point.coords, 0.0, 1.0);
        let ((column, right), (row, up)) = (cut(view.x, view.last_x), cut(view.y, view.last_y));
        self.between((row * view.stride + column) as usize, right, up)
    }

    /// What a body at `position` (m) with this sine and cosine of its heading sees.
    fn view(&self, position: &Vector2<f64>, sin: f64, cos: f64) -> View {
        let per_cell = 1.0 / self.frame.cell_m;
        let offset = (position - self.frame.origin_m.coords) * per_cell;
        View {
            // Half a cell back to its centre, two on for the border.
            x: (offset.x + 1.5) as f32,
            y: (offset.y + 1.5) as f32,
            sin: (sin * per_cell) as f32,
            cos: (cos * per_cell) as f32,
            last_x: self.frame.width as f32 + 2.5,
            last_y: self.frame.height as f32 + 2.5,
            stride: self.stride as u32,
        }
    }

    /// Tells the steps of every end, in parts of 256.
    #[inline(always)]
    fn visit(
        &self,
        ends: &Ends,
        position: &Vector2<f64>,
        sin: f64,
        cos: f64,
        mut take: impl FnMut(u32),
    ) {
        let view = self.view(position, sin, cos);
        let (xs, _) = ends.x_m.as_chunks::<TOGETHER>();
        let (ys, _) = ends.y_m.as_chunks::<TOGETHER>();
        let mut left = ends.count;
        for (x, y) in xs.iter().zip(ys) {
            let spots = view.spots(x, y);
            for k in 0..left.min(TOGETHER) {
                take(self.between(spots.place[k] as usize, spots.right[k], spots.up[k]));
            }
            left = left.saturating_sub(TOGETHER);
        }
    }

    /// Between four cells, the lower left of which is `place`: so far to the
    /// right and up, in parts of 256. In such parts of a step.
    #[inline(always)]
    fn between(&self, place: usize, right: u32, up: u32) -> u32 {
        let pair = |at: usize| match self.steps.get(at..at + 2) {
            Some(&[a, b]) => u32::from(a) * (PARTS - right) + u32::from(b) * right,
            _ => 0,
        };
        (pair(place) * (PARTS - up) + pair(place + self.stride) * up) / PARTS
    }
}

fn joint(sigmas_m: &[f64]) -> f64 {
    sigmas_m.iter().map(|s| s * s).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests;
