//! Mapping with known poses: a grid of log odds.
//!
//! Source: *Probabilistic Robotics*, §9.2, Tables 9.1 (`occupancy_grid_mapping`)
//! and 9.2 (`inverse_range_sensor_model`). A cell that a beam goes through gets
//! l_free, the one in which it ends l_occ, any other nothing.
//!
//! Departures, and why:
//! * Cells are found by walking along the beams ([`crate::ray_walk`]), not by
//!   asking of each cell which beam is nearest in bearing: the beams are lines,
//!   and a cell between two of them was not seen.
//! * A scan changes a cell once. Near the sensor many of its beams go through one
//!   cell, and are not independent measurements; and where one ends, none has passed.
//! * The prior l₀ is 0 (p = 0.5): it cancels in Table 9.1.
//! * Log odds are whole multiples of 2⁻¹⁶, so that sums are exact and scans may
//!   come in any order, and they stay within bounds, so that the map follows
//!   when a door opens (Yguel et al., *Update Policy of Dense Maps*, 2008;
//!   OctoMap's bounds are the ones here).
//! * A beam that met nothing clears, in the book, up to z_max. Where the laser
//!   drops readings, that is clearing through walls ([`NothingMet`]), and real
//!   ones have a z_max of 80 m: it clears up to 8 m, unless told otherwise.

mod model;

use nalgebra::Point2;
use rusty_geometry::{SE2, trig};
use thiserror::Error;

pub use self::model::{InverseModel, NothingMet};
use crate::ray_walk::RayWalk;
use crate::{Beams, Cell, GridFrame, OccupancyMap};
use rusty_floorplan::map_server::{FREE_BELOW, OCCUPIED_ABOVE};

/// The most cells of a grid: 290 m square in cells of 5 cm.
pub const MAX_CELLS: usize = 1 << 25;
/// No cell is farther from the world's origin than this many: beyond it, whole numbers
/// of cells no longer tell one from the next.
const FARTHEST_CELLS: f64 = (1_u64 << 40) as f64;
/// Cells by which a grid grows at once.
const GROWTH: i64 = 64;
/// Log odds of 1 in whole numbers.
const ONE: f64 = 65_536.0;

/// Log odds of `p`, in whole numbers.
fn fixed(p: f64) -> i32 {
    (trig::ln(p / (1.0 - p)) * ONE).round() as i32
}

/// Why a scan is not in the map.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GridError {
    /// The pose is none.
    #[error("a scan was taken at {0:?}, which is no pose; leave such scans out")]
    Pose(SE2),
    /// The scan was taken where there are no cells.
    #[error(
        "a scan was taken at ({x_m:.1e} m, {y_m:.1e} m), more than 2⁴⁰ cells from the origin; use \
         better poses or larger cells (--cell-m)"
    )]
    TooFar {
        /// Where the sensor was, world frame, m.
        x_m: f64,
        /// Where the sensor was, world frame, m.
        y_m: f64,
    },
    /// The scan reaches too far.
    #[error(
        "with a scan taken at ({x_m:.1} m, {y_m:.1} m) the map would have {cells:.1e} cells, more \
         than {MAX_CELLS}; use larger cells (--cell-m), shorter beams (--reach-m) or better poses"
    )]
    TooLarge {
        /// Where the sensor was, world frame, m.
        x_m: f64,
        /// Where the sensor was, world frame, m.
        y_m: f64,
        /// How many cells there would be.
        cells: f64,
    },
}

/// How far one beam of a scan says something.
#[derive(Clone, Debug)]
struct Reading {
    /// Where things begin: cells up to there are free.
    free_to: Point2<f64>,
    /// Where things end, if any were met.
    occupied_to: Option<Point2<f64>>,
    /// Whether the beam met nothing at all.
    is_nothing: bool,
}

/// A grid of log odds, which grows as more is seen.
#[derive(Clone, Debug)]
pub struct OccupancyGrid {
    model: InverseModel,
    /// Where the grid's corner is from the world's origin, in steps of growth.
    corner: [i64; 2],
    frame: GridFrame,
    log_odds: Vec<i32>,
    /// The scan that changed a cell last.
    changed_by: Vec<u32>,
    scans: u32,
    readings: Vec<Reading>,
}

impl OccupancyGrid {
    /// A grid before anything was seen.
    pub fn new(model: InverseModel) -> Self {
        let (origin_m, cell_m) = (Point2::origin(), model.cell_m);
        Self {
            model,
            corner: [0, 0],
            frame: GridFrame { origin_m, cell_m, width: 0, height: 0 },
            log_odds: Vec::new(),
            changed_by: Vec::new(),
            scans: 0,
            readings: Vec::new(),
        }
    }

    /// Where its cells lie now.
    pub fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// How many scans are in it.
    pub fn scans(&self) -> u32 {
        self.scans
    }

    /// Log odds of a cell, 0 where nothing is known.
    pub fn log_odds(&self, cell: usize) -> f64 {
        f64::from(self.log_odds[cell]) / ONE
    }

    /// How probable a cell is to be occupied.
    pub fn probability(&self, cell: usize) -> f64 {
        1.0 / (1.0 + trig::exp(-self.log_odds(cell)))
    }

    /// Takes in a scan (m, one a beam) from the pose of the robot in the world
    /// frame. Ranges that are no numbers, or not above 0, say nothing.
    ///
    /// # Errors
    /// [`GridError`]; the grid is then what it was before.
    pub fn add(&mut self, robot: &SE2, ranges_m: &[f64], beams: &Beams) -> Result<(), GridError> {
        if !robot.is_finite() {
            return Err(GridError::Pose(*robot));
        }
        let sensor = robot.compose(&beams.sensor_in_body);
        let eye = Point2::from(sensor.translation());
        self.read(&sensor, ranges_m, beams);
        self.make_room(eye)?;
        self.scans += 1;
        let readings = std::mem::take(&mut self.readings);
        // First all that is occupied: where one beam ends, none has passed.
        let occupied = fixed(self.model.p_occupied);
        for reading in &readings {
            let Some(to) = reading.occupied_to else { continue };
            for crossing in RayWalk::new(&self.frame, reading.free_to, to) {
                self.change(crossing.column, crossing.row, occupied);
            }
        }
        let free = fixed(self.model.p_free);
        for reading in &readings {
            let stops = reading.is_nothing && self.model.nothing_met == NothingMet::Stops;
            for crossing in RayWalk::new(&self.frame, eye, reading.free_to) {
                let cell = self.frame.index(crossing.column, crossing.row);
                if stops && cell.is_some_and(|cell| self.log_odds[cell] > 0) {
                    break;
                }
                self.change(crossing.column, crossing.row, free);
            }
        }
        self.readings = readings;
        Ok(())
    }

    /// Turns ranges into what they say.
    fn read(&mut self, sensor: &SE2, ranges_m: &[f64], beams: &Beams) {
        let reach_m = self.model.reach_m.unwrap_or(beams.range_max_m).min(beams.range_max_m);
        let half_m = 0.5 * self.model.thickness_m;
        self.readings.clear();
        for (k, &range_m) in ranges_m.iter().take(beams.count()).enumerate() {
            if range_m.is_nan() || range_m <= 0.0 {
                continue;
            }
            let direction = beams.direction(k);
            let at = |along_m: f64| sensor.transform_point(&Point2::from(direction * along_m));
            let is_hit = beams.is_hit(range_m) && range_m <= reach_m;
            // Something beyond the reach is no reading of nothing.
            let is_nothing = !beams.is_hit(range_m);
            if is_nothing && self.model.nothing_met == NothingMet::Ignored {
                continue;
            }
            let free_m = match (is_hit, is_nothing) {
                (true, _) => (range_m - half_m).max(0.0),
                (false, true) => reach_m.min(self.model.nothing_m),
                (false, false) => reach_m,
            };
            let free_to = at(free_m);
            let occupied_to = is_hit.then(|| at(range_m + half_m));
            self.readings.push(Reading { free_to, occupied_to, is_nothing });
        }
    }

    /// Changes a cell, once a scan.
    fn change(&mut self, column: i64, row: i64, by: i32) {
        let Some(cell) = self.frame.index(column, row) else { return };
        if self.changed_by[cell] == self.scans {
            return;
        }
        self.changed_by[cell] = self.scans;
        let (least, most) = (fixed(self.model.p_least), fixed(self.model.p_most));
        self.log_odds[cell] = (self.log_odds[cell] + by).clamp(least, most);
    }

    /// Grows until the eye and all readings lie inside.
    fn make_room(&mut self, eye: Point2<f64>) -> Result<(), GridError> {
        let ends = self.readings.iter().flat_map(|r| [Some(r.free_to), r.occupied_to]).flatten();
        let (mut low, mut high) = ([eye.x, eye.y], [eye.x, eye.y]);
        for point in ends {
            for axis in 0..2 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let inside = |v: &f64| (v / self.frame.cell_m).abs() <= FARTHEST_CELLS;
        if !low.iter().chain(&high).all(inside) {
            return Err(GridError::TooFar { x_m: eye.x, y_m: eye.y });
        }
        // Whole steps, and a cell more on each side against roundings.
        let step =
            |v: f64, more: f64| ((v / self.frame.cell_m + more) / GROWTH as f64).floor() as i64;
        let mut first = low.map(|v| step(v, -1.0));
        let mut end = high.map(|v| step(v, 1.0) + 1);
        if self.frame.cells() > 0 {
            let size = [self.frame.width, self.frame.height].map(|n| n as i64 / GROWTH);
            for axis in 0..2 {
                first[axis] = first[axis].min(self.corner[axis]);
                end[axis] = end[axis].max(self.corner[axis] + size[axis]);
            }
        }
        let size = [0, 1].map(|axis| end[axis] as f64 - first[axis] as f64);
        let cells = size[0] * size[1] * (GROWTH * GROWTH) as f64;
        if cells > MAX_CELLS as f64 {
            return Err(GridError::TooLarge { x_m: eye.x, y_m: eye.y, cells });
        }
        let size = size.map(|steps| steps as usize * GROWTH as usize);
        if first != self.corner || size != [self.frame.width, self.frame.height] {
            self.reframe(first, size);
        }
        Ok(())
    }

    /// Moves what is known into a grid with another corner and size, around the
    /// one before.
    fn reframe(&mut self, corner: [i64; 2], [width, height]: [usize; 2]) {
        let old = self.frame;
        let [x, y] = corner.map(|steps| (steps * GROWTH) as f64 * old.cell_m);
        let frame = GridFrame { origin_m: Point2::new(x, y), width, height, ..old };
        let (mut log_odds, mut changed_by) = (vec![0; frame.cells()], vec![0; frame.cells()]);
        let [right, up] = [0, 1].map(|axis| ((self.corner[axis] - corner[axis]) * GROWTH) as usize);
        for row in 0..old.height {
            let from = row * old.width..(row + 1) * old.width;
            let to = (row + up) * width + right;
            let to = to..to + old.width;
            log_odds[to.clone()].copy_from_slice(&self.log_odds[from.clone()]);
            changed_by[to].copy_from_slice(&self.changed_by[from]);
        }
        (self.corner, self.frame) = (corner, frame);
        (self.log_odds, self.changed_by) = (log_odds, changed_by);
    }

    /// The part of the grid of which something is known, as a frame, with the
    /// columns and rows at which it begins; `None` if nothing is.
    pub fn known(&self) -> Option<([usize; 2], GridFrame)> {
        let width = self.frame.width;
        let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
        for (cell, _) in self.log_odds.iter().enumerate().filter(|(_, odds)| **odds != 0) {
            for (axis, place) in [cell % width, cell / width].into_iter().enumerate() {
                low[axis] = low[axis].min(place);
                high[axis] = high[axis].max(place + 1);
            }
        }
        if high == [0; 2] {
            return None;
        }
        let cell_m = self.frame.cell_m;
        let at = |axis: usize| (self.corner[axis] * GROWTH + low[axis] as i64) as f64 * cell_m;
        let origin_m = Point2::new(at(0), at(1));
        let (width, height) = (high[0] - low[0], high[1] - low[1]);
        Some((low, GridFrame { origin_m, cell_m, width, height }))
    }

    /// The map: what is more probable than 0.65 to be occupied is, what is less
    /// than 0.196 is free, as in the files of ROS. As large as what is known.
    pub fn to_map(&self) -> OccupancyMap {
        let Some(([right, up], frame)) = self.known() else {
            return OccupancyMap::unknown(GridFrame { width: 1, height: 1, ..self.frame });
        };
        let (occupied, free) = (fixed(OCCUPIED_ABOVE), fixed(FREE_BELOW));
        let cell = |odds: &i32| match *odds {
            odds if odds > occupied => Cell::Occupied,
            odds if odds < free => Cell::Free,
            _ => Cell::Unknown,
        };
        let rows = self.log_odds.chunks_exact(self.frame.width).skip(up).take(frame.height);
        let cells = rows.flat_map(|row| row[right..right + frame.width].iter().map(cell));
        OccupancyMap { frame, cells: cells.collect() }
    }
}

#[cfg(test)]
mod tests;
