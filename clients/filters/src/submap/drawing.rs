//! Draws scans into a table of likelihoods, and marks what none of them looked at.

use nalgebra::{Point2, Vector2};
use rusty_geometry::{SE2, trig};

use super::{CELL_M, MOST, RADIUS_M, UNSEEN, Unseen, cell};
use crate::icp::Ray;

/// Deviation of an end from a wall of the table, m.
const BLUR_M: f64 = 0.08;
/// Cells to each side of an end that have a likelihood because of it.
const BLUR_CELLS: i32 = 4;
/// Ends of neighbouring beams no farther apart than this are on one wall, m.
const WALL_GAP_M: f64 = 0.4;
/// Behind an end this much counts as looked at, m: an end there goes through the wall.
const BEHIND_M: f64 = 0.5;
/// Size of the cells that say what was looked at, in cells of the table.
const SEEN_CELLS: i32 = 4;
const SEEN_M: f64 = 4.0 * CELL_M;

/// Likelihoods of a place, row by row.
pub(super) struct Drawing {
    /// Indices of the cell in the lower left corner, in cells from the origin.
    pub(super) corner: [i32; 2],
    /// Width and height, in cells.
    pub(super) size: [i32; 2],
    /// 0 to [`MOST`], or [`UNSEEN`].
    pub(super) cells: Vec<u8>,
    /// What all cells around it have.
    pub(super) beyond: u8,
}

impl Drawing {
    /// The likelihoods around the ends of scans, each with the pose of its body.
    pub(super) fn new(scans: &[(SE2, Vec<Ray>)], unseen: Unseen) -> Self {
        let placed = |(pose, rays): &(SE2, Vec<Ray>)| {
            let pose = *pose;
            drawn(rays).into_iter().map(move |point| pose.transform_point(&point))
        };
        let ends: Vec<Point2<f64>> =
            scans.iter().flat_map(placed).filter(|p| p.coords.norm() < RADIUS_M).collect();
        let (mut low, mut high) = ([0; 2], [0; 2]);
        for end in ends.iter().map(|end| [cell(end.x), cell(end.y)]) {
            for axis in 0..2 {
                low[axis] = low[axis].min(end[axis]);
                high[axis] = high[axis].max(end[axis]);
            }
        }
        let (margin, beyond) = match unseen {
            Unseen::Misses => (BLUR_CELLS, 0),
            Unseen::LeftOut => (BLUR_CELLS + cell(BEHIND_M), UNSEEN),
        };
        let corner = low.map(|c| c - margin);
        let size = [0, 1].map(|axis| high[axis] - corner[axis] + margin + 1);
        let mut cells = vec![0u8; (size[0] * size[1]) as usize];
        let kernel = kernel();
        for end in &ends {
            let (column, row) = (cell(end.x) - corner[0], cell(end.y) - corner[1]);
            for (dy, line) in (-BLUR_CELLS..).zip(&kernel) {
                let first = ((row + dy) * size[0] + column - BLUR_CELLS) as usize;
                let around = cells[first..first + line.len()].iter_mut();
                around.zip(line).for_each(|(cell, value)| *cell = (*cell).max(*value));
            }
        }
        let mut drawing = Self { corner, size, cells, beyond };
        if unseen == Unseen::LeftOut {
            drawing.mark_unseen(scans);
        }
        drawing
    }

    /// Marks the cells that no scan looked at.
    fn mark_unseen(&mut self, scans: &[(SE2, Vec<Ray>)]) {
        let mut seen = Seen::new(self);
        scans.iter().for_each(|(pose, rays)| seen.look(pose, rays));
        for (row, line) in (0..).zip(self.cells.chunks_mut(self.size[0] as usize)) {
            for (column, value) in (0..).zip(line) {
                if *value == 0 && !seen.has([column, row]) {
                    *value = UNSEEN;
                }
            }
        }
    }
}

/// What scans looked at, in coarse cells: up to their ends, between neighbouring beams up to
/// the nearer end, and a little behind.
struct Seen {
    corner: [i32; 2],
    size: [i32; 2],
    cells: Vec<bool>,
}

impl Seen {
    fn new(drawing: &Drawing) -> Self {
        let size = drawing.size.map(|cells| cells / SEEN_CELLS + 1);
        Self { corner: drawing.corner, size, cells: vec![false; (size[0] * size[1]) as usize] }
    }

    /// The coarse cell of a cell of the drawing.
    fn index(&self, cell: [i32; 2]) -> Option<usize> {
        let [x, y] = cell.map(|c| c.div_euclid(SEEN_CELLS));
        let is_inside = (0..self.size[0]).contains(&x) && (0..self.size[1]).contains(&y);
        is_inside.then_some((y * self.size[0] + x) as usize)
    }

    fn has(&self, cell: [i32; 2]) -> bool {
        self.index(cell).is_some_and(|k| self.cells[k])
    }

    fn look(&mut self, pose: &SE2, rays: &[Ray]) {
        let mut last: Option<(&Ray, f64)> = None;
        for ray in rays {
            // The sensor is on the ray, about where it passes the middle of the body.
            let length_m = ray.point.coords.dot(&ray.direction);
            let from = ray.point - ray.direction * length_m;
            self.look_along(pose, from, ray.direction, length_m);
            if let Some((last, last_m)) = last.filter(|(last, _)| last.beam + 1 == ray.beam) {
                let nearer_m = length_m.min(last_m);
                let apart_m = nearer_m * (ray.direction - last.direction).norm();
                let between = (apart_m / SEEN_M).floor() as u32;
                for k in 1..=between {
                    let part = f64::from(k) / f64::from(between + 1);
                    let direction = last.direction * (1.0 - part) + ray.direction * part;
                    self.look_along(pose, from, direction.normalize(), nearer_m);
                }
            }
            last = Some((ray, length_m));
        }
    }

    fn look_along(&mut self, pose: &SE2, from: Point2<f64>, along: Vector2<f64>, length_m: f64) {
        let step_m = 0.5 * SEEN_M;
        let steps = ((length_m + BEHIND_M) / step_m).floor() as u32;
        for k in 0..=steps {
            let at = pose.transform_point(&(from + along * (step_m * f64::from(k))));
            let at = [cell(at.x) - self.corner[0], cell(at.y) - self.corner[1]];
            if let Some(k) = self.index(at) {
                self.cells[k] = true;
            }
        }
    }
}

/// Ends of a scan and the walls between ends of neighbouring beams: without these, a
/// scan fits best where its beams end at the points of others, and not along the wall.
fn drawn(rays: &[Ray]) -> Vec<Point2<f64>> {
    let mut points: Vec<Point2<f64>> = rays.iter().map(|ray| ray.point).collect();
    for pair in rays.windows(2) {
        let gap = pair[1].point - pair[0].point;
        let gap_m = gap.norm();
        if pair[1].beam == pair[0].beam + 1 && gap_m < WALL_GAP_M {
            let between = (gap_m / CELL_M).floor() as u32;
            let part = |k: u32| f64::from(k) / f64::from(between + 1);
            points.extend((1..=between).map(|k| pair[0].point + gap * part(k)));
        }
    }
    points
}

/// The likelihoods around an end.
fn kernel() -> Vec<Vec<u8>> {
    let value = |x: i32, y: i32| {
        let away = CELL_M / BLUR_M;
        let square = away * away * f64::from(x * x + y * y);
        (f64::from(MOST) * trig::exp(-0.5 * square)).round() as u8
    };
    let all = -BLUR_CELLS..=BLUR_CELLS;
    all.clone().map(|y| all.clone().map(|x| value(x, y)).collect()).collect()
}
