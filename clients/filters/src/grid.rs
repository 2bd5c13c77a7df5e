//! A rectangle of square cells in the world frame.

use nalgebra::Point2;

/// Where the cells of a grid lie. Cell (0, 0) is at the lower left; cells are
/// numbered row by row from there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridFrame {
    /// Lower left corner in the world frame, m.
    pub origin_m: Point2<f64>,
    /// Side of a cell, m.
    pub cell_m: f64,
    /// Cells in x.
    pub width: usize,
    /// Cells in y.
    pub height: usize,
}

/// Steps to the eight neighbours of a cell, those across a corner last.
pub const NEIGHBOURS: [(i64, i64); 8] =
    [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];

impl GridFrame {
    /// The smallest grid of such cells that covers `bounds` (x and y from, x and
    /// y to, m) and `margin_m` around it; its corner is a multiple of `cell_m`.
    pub fn covering(bounds: [f64; 4], margin_m: f64, cell_m: f64) -> Self {
        let from = |v: f64| ((v - margin_m) / cell_m).floor();
        let to = |v: f64| ((v + margin_m) / cell_m).ceil();
        let [x0, y0] = [from(bounds[0]), from(bounds[1])];
        Self {
            origin_m: Point2::new(x0 * cell_m, y0 * cell_m),
            cell_m,
            width: (to(bounds[2]) - x0).max(1.0) as usize,
            height: (to(bounds[3]) - y0).max(1.0) as usize,
        }
    }

    /// How many cells.
    pub fn cells(&self) -> usize {
        self.width * self.height
    }

    /// Column and row of a point, which may lie outside.
    pub fn column_row(&self, point: Point2<f64>) -> (i64, i64) {
        let offset = (point - self.origin_m) / self.cell_m;
        (offset.x.floor() as i64, offset.y.floor() as i64)
    }

    /// Number of the cell in a column and row, if there is one.
    pub fn index(&self, column: i64, row: i64) -> Option<usize> {
        let (width, height) = (self.width as i64, self.height as i64);
        let inside = (0..width).contains(&column) && (0..height).contains(&row);
        inside.then_some((row * width + column) as usize)
    }

    /// Number of the cell that is this many columns and rows from another.
    pub fn beside(&self, cell: usize, (columns, rows): (i64, i64)) -> Option<usize> {
        self.index((cell % self.width) as i64 + columns, (cell / self.width) as i64 + rows)
    }

    /// Number of the cell that a point is in.
    pub fn cell_at(&self, point: Point2<f64>) -> Option<usize> {
        if !(point.x.is_finite() && point.y.is_finite()) {
            return None;
        }
        let (column, row) = self.column_row(point);
        self.index(column, row)
    }

    /// Centre of a cell, world frame, m.
    pub fn centre(&self, cell: usize) -> Point2<f64> {
        let (column, row) = (cell % self.width, cell / self.width);
        let along = |count: usize| (count as f64 + 0.5) * self.cell_m;
        Point2::new(self.origin_m.x + along(column), self.origin_m.y + along(row))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_and_points_find_each_other() {
        let frame = GridFrame::covering([0.0, 0.0, 12.0, 9.0], 0.5, 0.1);
        assert_eq!((frame.width, frame.height), (130, 100));
        for cell in [0, 77, frame.cells() - 1] {
            assert_eq!(frame.cell_at(frame.centre(cell)), Some(cell));
        }
        assert_eq!(frame.cell_at(Point2::new(-0.6, 1.0)), None);
        assert_eq!(frame.cell_at(Point2::new(1.0, 9.6)), None);
        assert_eq!(frame.cell_at(Point2::new(f64::NAN, 1.0)), None);
    }
}
