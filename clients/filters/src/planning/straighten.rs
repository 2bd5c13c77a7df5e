//! Few straight pieces instead of many steps.
//!
//! Source: the shortcut of K. Daniel, A. Nash, S. Koenig, A. Felner, *Theta\*:
//! any-angle path planning on grids* (JAIR 39, 2010), taken after the search and
//! not in it. Departure: a shortcut must not be dearer than what it replaces, by
//! the same cost as the search had; a shortcut that is merely free would draw a
//! way back to the corners that the cost has kept it from.

use nalgebra::Point2;

use super::{Clearance, Room};

/// Two costs this near are the same: a straight line is summed up from more
/// pieces than the steps next to it.
const SLACK: f64 = 1.0 + 1e-6;

/// The corners of a way through the centres of these cells, both ends included.
pub fn straighten(clearance: &Clearance, room: &Room, cells: &[usize]) -> Vec<Point2<f64>> {
    let frame = clearance.frame;
    let centres: Vec<Point2<f64>> = cells.iter().map(|cell| frame.centre(*cell)).collect();
    // What the way costs up to each cell.
    let mut so_far = vec![0.0];
    for pair in centres.windows(2) {
        so_far.push(so_far[so_far.len() - 1] + line_cost(clearance, room, pair[0], pair[1]));
    }
    let mut corners: Vec<Point2<f64>> = centres.first().copied().into_iter().collect();
    let mut at = 0;
    while at + 1 < centres.len() {
        let cheap = |to: &usize| {
            let straight = line_cost(clearance, room, centres[at], centres[*to]);
            straight <= (so_far[*to] - so_far[at]) * SLACK
        };
        // The next cell is always as cheap as itself.
        let to = (at + 1..centres.len()).rev().find(cheap).unwrap_or(at + 1);
        corners.push(centres[to]);
        at = to;
    }
    corners
}

/// What a straight piece costs, by the cells that it crosses; infinite where one
/// of them is too near to a wall.
pub fn line_cost(clearance: &Clearance, room: &Room, from: Point2<f64>, to: Point2<f64>) -> f64 {
    let along = to - from;
    let length_m = along.norm();
    // Five to a cell, each in the middle of its piece.
    let pieces = (5.0 * length_m / clearance.frame.cell_m).ceil().max(1.0);
    let cost = |k: usize| {
        let point = from + along * ((k as f64 + 0.5) / pieces);
        room.cost(clearance.at_point(point))
    };
    (0..pieces as usize).map(cost).sum::<f64>() * (length_m / pieces)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OccupancyMap;
    use crate::planning::{Routes, Unknown};
    use rusty_geometry::apartment;

    const ROOM: Room = Room { needed_m: 0.15, liked_m: 0.5, dislike: 4.0 };

    #[test]
    fn few_pieces_no_dearer_than_the_steps_and_as_clear() {
        let map = OccupancyMap::of_world(&apartment(), 0.1, 0.05);
        let clearance = Clearance::of_map(&map, Unknown::Wall);
        let cell = |x: f64, y: f64| map.frame.cell_at(Point2::new(x, y)).unwrap();
        for (from, to) in [((1.8, 7.0), (9.6, 3.0)), ((1.3, 2.5), (10.5, 7.8))] {
            let routes = Routes::new(&clearance, &ROOM, cell(from.0, from.1));
            let cells = routes.cells_to(cell(to.0, to.1));
            let corners = straighten(&clearance, &ROOM, &cells);
            assert!(corners.len() >= 4 && corners.len() < 25, "{}", corners.len());
            assert_eq!(corners[0], map.frame.centre(cells[0]));
            assert_eq!(corners.last(), Some(&map.frame.centre(cells[cells.len() - 1])));
            let cost: f64 =
                corners.windows(2).map(|p| line_cost(&clearance, &ROOM, p[0], p[1])).sum();
            assert!(cost < 1.02 * routes.cost(cell(to.0, to.1)), "{cost}");
            for pair in corners.windows(2) {
                for k in 0..=100 {
                    let point = pair[0] + (pair[1] - pair[0]) * (f64::from(k) / 100.0);
                    let distance_m = apartment().distance_to_nearest(point);
                    assert!(distance_m > ROOM.needed_m - 0.075, "{distance_m} m at {point}");
                }
            }
        }
    }

    #[test]
    fn a_way_of_one_cell_is_a_point_and_of_none_nothing() {
        let map = OccupancyMap::of_world(&apartment(), 0.1, 0.05);
        let clearance = Clearance::of_map(&map, Unknown::Wall);
        assert_eq!(straighten(&clearance, &ROOM, &[7]).len(), 1);
        assert!(straighten(&clearance, &ROOM, &[]).is_empty());
    }
}
