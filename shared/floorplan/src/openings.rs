//! Openings: where a floor that should be closed is open to the outside.
//!
//! The plane is searched in cells. The clearance of a cell is the distance from its
//! centre to the nearest wall; the width of a cell is the largest radius of a disc
//! that can come there from outside, cell by cell and through no wall: the widest
//! path (Pollack 1960), by the algorithm of Dijkstra (1959). Where the disc is
//! narrowest on its way to the floor is an opening. It is closed, and the search is
//! repeated.

use std::collections::BinaryHeap;

use nalgebra::{Point2, Vector2};
use rusty_geometry::World;

/// Most openings that are found.
pub const MAX_OPENINGS: usize = 8;
/// Smallest cell, m.
const MIN_CELL_M: f64 = 0.05;
/// About the number of cells of a search.
const CELLS: f64 = 250_000.0;
/// Cells around the bounds of the world.
const MARGIN_CELLS: f64 = 3.0;

/// A place at which a floor is open to the outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// Its middle, world frame, m.
    pub at_m: [f64; 2],
    /// Its width, m.
    pub width_m: f64,
}

/// What a search for openings found.
#[derive(Clone, Debug, PartialEq)]
pub struct Floor {
    /// A point on the floor, m; `None` if no floor is enclosed.
    pub at_m: Option<[f64; 2]>,
    /// Openings narrower than this may not be found, m.
    pub resolution_m: f64,
    /// The openings, the widest first; at most [`MAX_OPENINGS`].
    pub openings: Vec<Opening>,
}

/// Searches for the openings of the floor at `start_m` (world frame, m), or else of
/// the floor that is enclosed best: the place whose clearance exceeds the width of
/// the way to it most.
#[must_use]
pub fn find_openings(world: &World, start_m: Option<[f64; 2]>) -> Floor {
    let mut plane = Plane::new(world);
    let resolution_m = plane.cell_m;
    let (widths, _) = plane.widths();
    let depth = |cell: &usize| plane.clearances[*cell] - widths[*cell];
    let floor = match start_m {
        Some(start) => plane.cell_at(start),
        None => (0..widths.len()).max_by(|a, b| depth(a).total_cmp(&depth(b))),
    };
    // A disc that fits a little better than it comes there is in no room.
    let floor = floor.filter(|cell| depth(cell) > 2.0 * resolution_m);
    let at_m = floor.map(|cell| start_m.unwrap_or(plane.centre(cell)));
    let mut openings = Vec::new();
    while let (Some(floor), true) = (floor, openings.len() < MAX_OPENINGS) {
        let (widths, before) = plane.widths();
        if widths[floor] <= 0.0 {
            break;
        }
        // The first cell from outside that is as narrow as the whole way.
        let mut cell = floor;
        while let Some(next) = before[cell].filter(|next| widths[*next] <= widths[floor]) {
            cell = next;
        }
        let (at_m, clearance_m) = (plane.centre(cell), plane.clearances[cell]);
        openings.push(Opening { at_m, width_m: 2.0 * clearance_m });
        plane.close(at_m, clearance_m + resolution_m);
    }
    Floor { at_m, resolution_m, openings }
}

/// The plane in cells.
struct Plane {
    corner_m: [f64; 2],
    cell_m: f64,
    columns: usize,
    /// Distance from the centre of each cell to the nearest wall, m.
    clearances: Vec<f64>,
    /// Whether there is a way to the next cell in x, and in y.
    is_free: Vec<[bool; 2]>,
}

impl Plane {
    fn new(world: &World) -> Self {
        let [x0, y0, x1, y1] = world.bounds();
        let cell_m = ((x1 - x0) * (y1 - y0) / CELLS).sqrt().max(MIN_CELL_M);
        // A long and narrow plane would have more cells.
        let cell_m = cell_m.max((x1 - x0).max(y1 - y0) / CELLS);
        let count =
            |from: f64, to: f64| ((to - from) / cell_m + 2.0 * MARGIN_CELLS).ceil() as usize;
        let (columns, rows) = (count(x0, x1), count(y0, y1));
        let corner_m = [x0, y0].map(|v| v - MARGIN_CELLS * cell_m);
        let mut plane = Self {
            corner_m,
            cell_m,
            columns,
            clearances: vec![0.0; columns * rows],
            is_free: Vec::new(),
        };
        for cell in 0..columns * rows {
            let centre = Point2::from(plane.centre(cell));
            plane.clearances[cell] = world.distance_to_nearest(centre);
            let free = |direction| world.first_wall(centre, direction, cell_m).is_none();
            plane.is_free.push([free(Vector2::x()), free(Vector2::y())]);
        }
        plane
    }

    fn centre(&self, cell: usize) -> [f64; 2] {
        let along = |from: f64, count: usize| from + self.cell_m * (count as f64 + 0.5);
        let [x, y] = self.corner_m;
        [along(x, cell % self.columns), along(y, cell / self.columns)]
    }

    fn cell_at(&self, point_m: [f64; 2]) -> Option<usize> {
        let [x, y] = [0, 1].map(|k| ((point_m[k] - self.corner_m[k]) / self.cell_m).floor());
        let rows = self.clearances.len() / self.columns;
        let inside = x >= 0.0 && y >= 0.0 && x < self.columns as f64 && y < rows as f64;
        inside.then_some(y as usize * self.columns + x as usize)
    }

    /// The cells next to one that can be reached from it.
    fn next(&self, cell: usize) -> impl Iterator<Item = usize> {
        let columns = self.columns;
        let (is_last, is_first) = (cell % columns + 1 == columns, cell.is_multiple_of(columns));
        let is_top = cell + columns >= self.clearances.len();
        let [east, north] = self.is_free[cell];
        let west = !is_first && self.is_free[cell - 1][0];
        let south = cell >= columns && self.is_free[cell - columns][1];
        let ways = [
            (east && !is_last).then(|| cell + 1),
            (north && !is_top).then(|| cell + columns),
            west.then(|| cell - 1),
            south.then(|| cell - columns),
        ];
        ways.into_iter().flatten()
    }

    /// The width of each cell, m (0 where nothing comes from outside), and the cell
    /// before it on the way from outside.
    fn widths(&self) -> (Vec<f64>, Vec<Option<usize>>) {
        let count = self.clearances.len();
        let (mut widths, mut before) = (vec![0.0; count], vec![None; count]);
        // Bits of numbers that are not negative have the order of the numbers.
        let mut heap: BinaryHeap<(u64, usize)> = BinaryHeap::new();
        for (cell, width) in widths.iter_mut().enumerate() {
            let column = cell % self.columns;
            let is_edge = column == 0 || column + 1 == self.columns;
            if is_edge || cell < self.columns || cell + self.columns >= count {
                *width = f64::INFINITY;
                heap.push((f64::INFINITY.to_bits(), cell));
            }
        }
        while let Some((bits, cell)) = heap.pop() {
            if f64::from_bits(bits) < widths[cell] {
                continue;
            }
            for next in self.next(cell) {
                let width = widths[cell].min(self.clearances[next]);
                if width > widths[next] {
                    widths[next] = width;
                    before[next] = Some(cell);
                    heap.push((width.to_bits(), next));
                }
            }
        }
        (widths, before)
    }

    /// Closes an opening by a disc.
    fn close(&mut self, at_m: [f64; 2], radius_m: f64) {
        for cell in 0..self.clearances.len() {
            let away = Point2::from(self.centre(cell)) - Point2::from(at_m);
            if away.norm() <= radius_m {
                self.clearances[cell] = 0.0;
            }
        }
    }
}
