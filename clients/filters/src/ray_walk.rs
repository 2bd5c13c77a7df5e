//! The cells that a straight line goes through, one after the other.
//!
//! Source: J. Amanatides and A. Woo, *A Fast Voxel Traversal Algorithm for Ray
//! Tracing*, Eurographics 1987: from a cell the line goes on into the neighbour
//! whose border it meets first, so none is left out and none is named twice.
//!
//! Departure: how many borders there are in x and in y is counted first, from the
//! two cells that hold the ends. So the walk ends in the cell of the far end,
//! however the shares at which borders are met are rounded.

use nalgebra::Point2;

use crate::GridFrame;

/// A cell and the part of the line that is in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Column of the cell, which may lie outside the grid.
    pub column: i64,
    /// Row of the cell, which may lie outside the grid.
    pub row: i64,
    /// Where the line enters it, as a share of the line: 0 at its start.
    pub enters: f64,
    /// Where it leaves it, or 1 in the last cell.
    pub leaves: f64,
}

/// The walk itself: an iterator over [`Crossing`]s.
#[derive(Clone, Debug)]
pub struct RayWalk {
    at: [i64; 2],
    step: [i64; 2],
    /// Borders still to be met in each direction.
    left: [u64; 2],
    /// Share of the line at which the next of them is met.
    next: [f64; 2],
    /// Share of the line between two of them.
    between: [f64; 2],
    enters: f64,
    ended: bool,
}

impl RayWalk {
    /// The line from `from` to `to`, world frame, m. No cells if one of the two
    /// is not finite.
    pub fn new(frame: &GridFrame, from: Point2<f64>, to: Point2<f64>) -> Self {
        let finite = [from, to].iter().all(|p| p.x.is_finite() && p.y.is_finite());
        let (begin, end) = (frame.column_row(from), frame.column_row(to));
        let along = (to - from) / frame.cell_m;
        let start = (from - frame.origin_m) / frame.cell_m;
        let mut walk = Self {
            at: [begin.0, begin.1],
            step: [(end.0 - begin.0).signum(), (end.1 - begin.1).signum()],
            left: [end.0.abs_diff(begin.0), end.1.abs_diff(begin.1)],
            next: [f64::INFINITY; 2],
            between: [along.x.abs().recip(), along.y.abs().recip()],
            enters: 0.0,
            ended: !finite,
        };
        for axis in 0..2 {
            if walk.left[axis] > 0 {
                let border = walk.at[axis] + i64::from(walk.step[axis] > 0);
                walk.next[axis] = ((border as f64 - start[axis]) / along[axis]).max(0.0);
            }
        }
        walk
    }
}

impl Iterator for RayWalk {
    type Item = Crossing;

    fn next(&mut self) -> Option<Crossing> {
        if self.ended {
            return None;
        }
        let [column, row] = self.at;
        let enters = self.enters;
        self.ended = self.left == [0; 2];
        if self.ended {
            return Some(Crossing { column, row, enters, leaves: 1.0 });
        }
        let axis = usize::from(self.next[1] < self.next[0]);
        let leaves = self.next[axis].min(1.0);
        self.at[axis] += self.step[axis];
        self.left[axis] -= 1;
        self.next[axis] =
            if self.left[axis] > 0 { self.next[axis] + self.between[axis] } else { f64::INFINITY };
        self.enters = leaves;
        Some(Crossing { column, row, enters, leaves })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    const FRAME: GridFrame =
        GridFrame { origin_m: Point2::new(-1.0, 2.0), cell_m: 0.1, width: 20, height: 20 };

    fn cells(from: [f64; 2], to: [f64; 2]) -> Vec<(i64, i64)> {
        let walk = RayWalk::new(&FRAME, Point2::from(from), Point2::from(to));
        walk.map(|c| (c.column, c.row)).collect()
    }

    #[test]
    fn cells_that_a_dense_row_of_points_is_in_are_walked_through_in_order() {
        let mut random = Random::new(5, 1);
        for _ in 0..500 {
            let mut point =
                || Point2::new(2.4 * random.uniform() - 1.2, 2.4 * random.uniform() + 1.8);
            let (from, to) = (point(), point());
            let walked: Vec<Crossing> = RayWalk::new(&FRAME, from, to).collect();
            let mut sampled = Vec::new();
            for k in 0..=20_000 {
                let cell = FRAME.column_row(from + (to - from) * (f64::from(k) / 20_000.0));
                if sampled.last() != Some(&cell) {
                    sampled.push(cell);
                }
            }
            // Samples miss what the line goes through for less than one of their
            // steps, and nothing else.
            let seen: Vec<(i64, i64)> = walked
                .iter()
                .filter(|c| {
                    c.leaves - c.enters > 1.01 / 20_000.0 || sampled.contains(&(c.column, c.row))
                })
                .map(|c| (c.column, c.row))
                .collect();
            assert_eq!(seen, sampled, "{from} to {to}");
            assert!(walked.windows(2).all(|w| {
                let (a, b) = (w[0], w[1]);
                a.leaves == b.enters && (a.column - b.column).abs() + (a.row - b.row).abs() == 1
            }));
        }
    }

    #[test]
    fn lines_along_borders_and_through_corners_end_where_they_should() {
        assert_eq!(cells([-0.95, 2.05], [-0.95, 2.05]), [(0, 0)]);
        assert_eq!(cells([-0.95, 2.05], [-0.65, 2.05]), [(0, 0), (1, 0), (2, 0), (3, 0)]);
        assert_eq!(cells([-0.65, 2.05], [-0.95, 2.05]), [(3, 0), (2, 0), (1, 0), (0, 0)]);
        for (from, to) in [
            ([-1.0, 2.0], [0.0, 3.0]),
            ([0.0, 3.0], [-1.0, 2.0]),
            ([-1.0, 3.0], [0.0, 2.0]),
            ([-0.5, 2.5], [-0.5, 3.9]),
            ([-0.5, 3.9], [-0.5, 2.0]),
        ] {
            let (begin, end) = (Point2::from(from), Point2::from(to));
            let walked = cells(from, to);
            assert_eq!(walked.first(), Some(&FRAME.column_row(begin)));
            assert_eq!(walked.last(), Some(&FRAME.column_row(end)));
        }
        assert!(cells([f64::NAN, 2.0], [0.0, 2.0]).is_empty());
    }
}
