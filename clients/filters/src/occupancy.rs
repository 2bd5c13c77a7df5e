//! A map of cells: free, occupied, or never seen.

pub use rusty_floorplan::map_server::Cell;
use rusty_geometry::World;

use crate::GridFrame;

/// A map of cells in the world frame.
#[derive(Clone, Debug, PartialEq)]
pub struct OccupancyMap {
    /// Where the cells lie.
    pub frame: GridFrame,
    /// What is known of each, row by row from the lower left.
    pub cells: Vec<Cell>,
}

impl OccupancyMap {
    /// A map of which nothing is known.
    pub fn unknown(frame: GridFrame) -> Self {
        Self { frame, cells: vec![Cell::Unknown; frame.cells()] }
    }

    /// The walls of a floor plan: a cell with a piece of wall in it is occupied,
    /// all others are free, those behind the walls included.
    pub fn of_world(world: &World, margin_m: f64, cell_m: f64) -> Self {
        let frame = GridFrame::covering(world.bounds(), margin_m, cell_m);
        let mut cells = vec![Cell::Free; frame.cells()];
        for wall in world.walls() {
            // Steps of a tenth of a cell cannot jump over one by more than a corner.
            for point in wall.points(0.1 * cell_m) {
                if let Some(cell) = frame.cell_at(point) {
                    cells[cell] = Cell::Occupied;
                }
            }
        }
        Self { frame, cells }
    }

    /// What is known of the cell at a point; beyond the map nothing is.
    pub fn at(&self, point: nalgebra::Point2<f64>) -> Cell {
        self.frame.cell_at(point).map_or(Cell::Unknown, |cell| self.cells[cell])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point2;

    #[test]
    fn walls_are_where_the_plan_has_them() {
        let world = rusty_geometry::apartment();
        let map = OccupancyMap::of_world(&world, 0.2, 0.05);
        for (cell, found) in map.cells.iter().enumerate() {
            let distance_m = world.distance_to_nearest(map.frame.centre(cell));
            // Half the diagonal of a cell: a wall farther off is not in it.
            let may_be = distance_m <= 0.05 * 0.7072;
            assert!(may_be || *found == Cell::Free, "cell {cell}, {distance_m} m from a wall");
            assert!(distance_m > 0.024 || *found == Cell::Occupied, "cell {cell}, {distance_m} m");
        }
        assert_eq!(map.at(Point2::new(100.0, 0.0)), Cell::Unknown);
    }
}
