//! How far the nearest wall is, for every cell of a map, as one who looks for ways
//! sees it: what is unknown may count as a wall. The distances are those of
//! [`crate::distance_field`].

use nalgebra::Point2;

use crate::distance_field::squares_to;
use crate::{Cell, GridFrame, OccupancyMap};

/// How an unknown cell counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// Not to be entered; but the body may hang over it, as at the edge of what
    /// an explorer has seen.
    Shut,
    /// A wall.
    Wall,
}

/// Distance of every cell to the nearest cell that must not be touched.
#[derive(Clone, Debug, PartialEq)]
pub struct Clearance {
    /// Where the cells lie.
    pub frame: GridFrame,
    /// From centre to centre, m; infinite where there is no wall at all.
    distances_m: Vec<f64>,
}

impl Clearance {
    /// From the cells that are occupied, and as `unknown` has it from those that
    /// is unknown.
    pub fn of_map(map: &OccupancyMap, unknown: Unknown) -> Self {
        let frame = map.frame;
        let squares = squares_to(map, |cell| match cell {
            Cell::Free => false,
            Cell::Occupied => true,
            Cell::Unknown => unknown == Unknown::Wall,
        });
        let shut = |cell: &Cell| *cell == Cell::Unknown && unknown == Unknown::Shut;
        let distance_m = |(square, cell): (&f64, &Cell)| {
            if shut(cell) { 0.0 } else { square.sqrt() * frame.cell_m }
        };
        let distances_m = squares.iter().zip(&map.cells).map(distance_m).collect();
        Self { frame, distances_m }
    }

    /// Adds a point (world frame, m) that must not be touched, to cells no farther than
    /// `within_m` from it.
    pub fn block(&mut self, point: Point2<f64>, within_m: f64) {
        let (column, row) = self.frame.column_row(point);
        let reach = (within_m / self.frame.cell_m).ceil() as i64;
        for (column, row) in (row - reach..=row + reach)
            .flat_map(|row| (column - reach..=column + reach).map(move |column| (column, row)))
        {
            let Some(cell) = self.frame.index(column, row) else { continue };
            let distance_m = (self.frame.centre(cell) - point).norm();
            self.distances_m[cell] = self.distances_m[cell].min(distance_m);
        }
    }

    /// Distance from the centre of a cell to that of the nearest wall, m.
    pub fn at(&self, cell: usize) -> f64 {
        self.distances_m[cell]
    }

    /// The same of the cell that a point is in; 0 beyond the map.
    pub fn at_point(&self, point: Point2<f64>) -> f64 {
        self.frame.cell_at(point).map_or(0.0, |cell| self.at(cell))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    #[test]
    fn every_distance_is_that_to_the_nearest_wall_of_all() {
        let mut random = Random::new(1, 1);
        for (width, height, share) in [(17, 23, 0.05), (40, 1, 0.1), (1, 9, 0.3), (30, 20, 0.5)] {
            let frame = GridFrame { origin_m: Point2::new(-1.0, 2.0), cell_m: 0.1, width, height };
            let mut map = OccupancyMap::unknown(frame);
            for cell in &mut map.cells {
                *cell = match random.uniform() {
                    u if u < share => Cell::Occupied,
                    u if u < 2.0 * share => Cell::Unknown,
                    _ => Cell::Free,
                };
            }
            for unknown in [Unknown::Shut, Unknown::Wall] {
                let found = Clearance::of_map(&map, unknown);
                let wall = |c: &Cell| match c {
                    Cell::Unknown => unknown == Unknown::Wall,
                    known => *known == Cell::Occupied,
                };
                for cell in 0..frame.cells() {
                    if map.cells[cell] == Cell::Unknown && unknown == Unknown::Shut {
                        assert_eq!(found.at(cell), 0.0);
                        continue;
                    }
                    let walls = (0..frame.cells()).filter(|w| wall(&map.cells[*w]));
                    let nearest = walls
                        .map(|w| (frame.centre(w) - frame.centre(cell)).norm())
                        .fold(f64::INFINITY, f64::min);
                    let found_m = found.at(cell);
                    let same = found_m == nearest || (found_m - nearest).abs() < 1e-9;
                    assert!(same, "{found_m} for {nearest}");
                }
            }
        }
    }

    #[test]
    fn without_walls_nothing_is_near_and_beyond_the_map_all_is() {
        let frame = GridFrame { origin_m: Point2::new(0.0, 0.0), cell_m: 0.5, width: 4, height: 3 };
        let map = OccupancyMap { frame, cells: vec![Cell::Free; 12] };
        let found = Clearance::of_map(&map, Unknown::Wall);
        assert_eq!(found.at_point(Point2::new(1.0, 1.0)), f64::INFINITY);
        assert_eq!(found.at_point(Point2::new(3.0, 1.0)), 0.0);
    }
}
