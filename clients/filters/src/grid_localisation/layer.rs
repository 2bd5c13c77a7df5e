//! All cells of one heading.

use std::ops::Range;

use nalgebra::Vector2;

use crate::GridFrame;

/// The widest variance of a kernel of three cells, cells².
const WIDEST: f64 = 0.5;
/// The most kernels for the error of one motion.
const MOST_KERNELS: f64 = 32.0;
/// A motion of more cells than this leaves every grid.
const FAR: f64 = 1e9;

/// All cells of one heading.
#[derive(Clone, Debug)]
pub(super) struct Layer {
    /// From the centres of the grid to the poses of the cells, world frame, m.
    pub offset_m: Vector2<f64>,
    /// Row by row, as in [`GridFrame`].
    pub masses: Vec<f64>,
    /// Only these rows have mass.
    pub rows: Range<usize>,
}

impl Layer {
    /// Adds mass to a cell that is `columns` and `rows` from another.
    pub fn add(&mut self, frame: &GridFrame, cell: usize, by: (i64, i64), mass: f64) {
        let column = ((cell % frame.width) as i64).saturating_add(by.0);
        let row = ((cell / frame.width) as i64).saturating_add(by.1);
        let Some(target) = frame.index(column, row) else { return };
        self.masses[target] += mass;
        let row = row as usize;
        self.rows = if self.rows.is_empty() {
            row..row + 1
        } else {
            self.rows.start.min(row)..self.rows.end.max(row + 1)
        };
    }

    /// Number and mass of the cells with mass, in order.
    pub fn occupied(&self, width: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let cells = self.rows.start * width..self.rows.end * width;
        cells.map(|cell| (cell, self.masses[cell])).filter(|(_, mass)| *mass > 0.0)
    }

    pub fn clear(&mut self, width: usize) {
        self.masses[self.rows.start * width..self.rows.end * width].fill(0.0);
        self.rows = 0..0;
    }

    /// Adds a share of another layer at the same poses. Where a pose is between cells,
    /// the four around it have parts of it with the same mean.
    pub fn add_layer(&mut self, frame: &GridFrame, from: &Self, share: f64) {
        let way = (from.offset_m - self.offset_m) / frame.cell_m;
        let whole = way.map(f64::floor);
        let part = way - whole;
        let (x, y) = (whole.x as i64, whole.y as i64);
        let corners = [
            ((x, y), (1.0 - part.x) * (1.0 - part.y)),
            ((x + 1, y), part.x * (1.0 - part.y)),
            ((x, y + 1), (1.0 - part.x) * part.y),
            ((x + 1, y + 1), part.x * part.y),
        ];
        for (cell, mass) in from.occupied(frame.width) {
            for (by, weight) in corners {
                if weight > 0.0 {
                    self.add(frame, cell, by, share * weight * mass);
                }
            }
        }
    }

    /// Moves all cells by a way in the world frame, m. `spare` is an empty layer.
    pub fn move_by(&mut self, frame: &GridFrame, way_m: Vector2<f64>, spare: &mut Self) {
        self.offset_m += way_m;
        let whole = (self.offset_m / frame.cell_m).map(f64::round);
        let is_far = !(whole.x.abs() < FAR && whole.y.abs() < FAR);
        self.offset_m =
            if is_far { Vector2::zeros() } else { self.offset_m - whole * frame.cell_m };
        if whole == Vector2::zeros() || self.rows.is_empty() {
            return;
        }
        spare.offset_m = self.offset_m;
        for (cell, mass) in self.occupied(frame.width).take_while(|_| !is_far) {
            spare.add(frame, cell, (whole.x as i64, whole.y as i64), mass);
        }
        self.clear(frame.width);
        std::mem::swap(self, spare);
    }

    /// Spreads the masses by these variances in x and y, cells². Nothing leaves the grid.
    pub fn spread(&mut self, frame: &GridFrame, variances: [f64; 2]) {
        if self.rows.is_empty() {
            return;
        }
        let (times, share) = kernel(variances[0]);
        for _ in 0..times {
            for row in self.rows.clone() {
                blur(&mut self.masses, row * frame.width, 1, frame.width, share);
            }
        }
        let (times, share) = kernel(variances[1]);
        for _ in 0..times {
            let (from, to) =
                (self.rows.start.saturating_sub(1), (self.rows.end + 1).min(frame.height));
            self.rows = from..to;
            for column in 0..frame.width {
                let first = from * frame.width + column;
                blur(&mut self.masses, first, frame.width, to - from, share);
            }
        }
    }
}

/// Number of kernels (a, 1 − 2a, a), and a, for a variance in cells².
pub(super) fn kernel(variance: f64) -> (usize, f64) {
    let times = (variance / WIDEST).ceil().clamp(0.0, MOST_KERNELS);
    if times > 0.0 {
        (times as usize, (0.5 * variance / times).min(0.5 * WIDEST))
    } else {
        (0, 0.0)
    }
}

/// Applies a kernel along a line of cells.
fn blur(masses: &mut [f64], first: usize, stride: usize, count: usize, share: f64) {
    let mut before = masses[first];
    for k in 0..count {
        let cell = first + k * stride;
        let here = masses[cell];
        let after = if k + 1 < count { masses[cell + stride] } else { here };
        masses[cell] = here + share * (before - 2.0 * here + after);
        before = here;
    }
}
