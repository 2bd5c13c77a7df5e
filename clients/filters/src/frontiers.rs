//! Where a map ends: free cells next to unknown cells.
//!
//! Source: B. Yamauchi, *A frontier-based approach for autonomous exploration*
//! (IEEE CIRA 1997): cells at the edge of open space are grouped into regions by
//! their neighbours; a region larger than the robot is a frontier.

use crate::grid::NEIGHBOURS;
use crate::{Cell, OccupancyMap};

/// A region at the edge of what is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frontier {
    /// Its cells, which are free, in the order in which they were found.
    pub cells: Vec<usize>,
}

/// The frontiers of a map that have this many cells or more, in the order of
/// their first cell.
pub fn frontiers(map: &OccupancyMap, least_cells: usize) -> Vec<Frontier> {
    let edge: Vec<bool> = (0..map.cells.len()).map(|cell| is_edge(map, cell)).collect();
    let mut seen = vec![false; edge.len()];
    let mut found = Vec::new();
    for first in 0..edge.len() {
        if !edge[first] || seen[first] {
            continue;
        }
        let mut cells = vec![first];
        seen[first] = true;
        let mut next = 0;
        while let Some(cell) = cells.get(next).copied() {
            next += 1;
            for step in NEIGHBOURS {
                if let Some(beside) = map.frame.beside(cell, step)
                    && edge[beside]
                    && !seen[beside]
                {
                    seen[beside] = true;
                    cells.push(beside);
                }
            }
        }
        if cells.len() >= least_cells {
            found.push(Frontier { cells });
        }
    }
    found
}

/// Whether a cell is free and has one next to it, not across a corner, that
/// is unknown.
pub fn is_edge(map: &OccupancyMap, cell: usize) -> bool {
    let unknown = |step: &(i64, i64)| {
        // Beyond the map everything is unknown.
        map.frame.beside(cell, *step).is_none_or(|other| map.cells[other] == Cell::Unknown)
    };
    map.cells[cell] == Cell::Free && NEIGHBOURS[..4].iter().any(unknown)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GridFrame;
    use nalgebra::Point2;

    /// A map drawn in letters, the top row first: `.` free, `#` occupied, else
    /// unknown.
    fn drawn(rows: &[&str]) -> OccupancyMap {
        let (width, height) = (rows[0].len(), rows.len());
        let frame = GridFrame { origin_m: Point2::origin(), cell_m: 1.0, width, height };
        let cell = |c: u8| match c {
            b'.' => Cell::Free,
            b'#' => Cell::Occupied,
            _ => Cell::Unknown,
        };
        OccupancyMap { frame, cells: rows.iter().rev().flat_map(|r| r.bytes().map(cell)).collect() }
    }

    #[test]
    fn regions_at_the_edge_are_found_and_grouped() {
        let map = drawn(&[
            "########", //
            "#....?.#", "#...?..#", "#......#", "#......#", "#......#", "#.##?###", "########",
        ]);
        let found = frontiers(&map, 1);
        assert_eq!(found.len(), 2, "{found:?}");
        // The one above the gap in the wall, and those around the pair.
        let sizes: Vec<usize> = found.iter().map(|f| f.cells.len()).collect();
        assert_eq!(sizes, [1, 5], "{found:?}");
        for cell in found.iter().flat_map(|f| &f.cells) {
            assert!(is_edge(&map, *cell));
        }
        assert_eq!(frontiers(&map, 2).len(), 1);
    }

    #[test]
    fn the_end_of_the_map_is_an_edge_and_a_closed_room_has_none() {
        assert_eq!(frontiers(&drawn(&["...", "...", "..."]), 1)[0].cells.len(), 8);
        assert!(frontiers(&drawn(&["####", "#..#", "####"]), 1).is_empty());
        assert!(frontiers(&OccupancyMap::unknown(drawn(&["??"]).frame), 1).is_empty());
    }
}
