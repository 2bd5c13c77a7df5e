//! The cheapest way from one place to every other.
//!
//! Source: E. Dijkstra, *A note on two problems in connexion with graphs*
//! (Numerische Mathematik 1, 1959), on cells with eight neighbours; as a
//! navigation function of a mobile robot J.-C. Latombe, *Robot Motion Planning*
//! (1991), ch. 7. One search answers for all aims, which an explorer needs; A*
//! would save a mapped robot some milliseconds a waypoint.
//!
//! Obstacles grow by the radius of the body, which makes the robot a point (T.
//! Lozano-Pérez, *Spatial planning: a configuration space approach*, IEEE
//! Transactions on Computers C-32(2), 1983); and a step costs its length, more
//! where a wall is nearer than one would like, so that a way goes through the
//! middle of a door where the shortest would touch its jamb.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::Point2;
use rusty_contract::Start;

use super::Clearance;
use crate::grid::NEIGHBOURS;
use crate::surroundings::Caution;

/// A step that just passes costs five times its length: as long as there is a
/// way with room that is not five times as long, that is taken.
const DISLIKE: f64 = 4.0;

/// How much room a robot needs, and how much it likes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// No way comes nearer to a wall than this, m.
    pub needed_m: f64,
    /// From here on, no more room makes a way any better, m.
    pub liked_m: f64,
    /// At `needed_m` a step costs this many times its length more.
    pub dislike: f64,
}

impl Room {
    /// For a robot on a map with such cells: body and margin, and half the
    /// diagonal by which it may be off the centre of its cell.
    pub fn on_cells(start: &Start, caution: &Caution, liked_m: f64, cell_m: f64) -> Self {
        let needed_m = start.robot.body_radius_m + caution.margin_m + 0.71 * cell_m;
        Self { needed_m, liked_m, dislike: DISLIKE }
    }

    /// What a step costs for each metre of it where the nearest wall is this far;
    /// infinite where it is too near.
    pub fn cost(&self, clearance_m: f64) -> f64 {
        if clearance_m < self.needed_m {
            return f64::INFINITY;
        }
        let span_m = self.liked_m - self.needed_m;
        let lack = if span_m > 0.0 { (self.liked_m - clearance_m) / span_m } else { 0.0 };
        let lack = lack.max(0.0);
        1.0 + self.dislike * lack * lack
    }
}

/// The cheapest ways from a start.
#[derive(Clone, Debug)]
pub struct Routes {
    start: usize,
    costs: Vec<f64>,
    /// From where each cell is reached; itself where it is not, or the start.
    from: Vec<usize>,
}

impl Routes {
    /// All ways from the cell `start`; where that is too near to a wall, there
    /// are none.
    pub fn new(clearance: &Clearance, room: &Room, start: usize) -> Self {
        let frame = clearance.frame;
        let weight: Vec<f64> =
            (0..frame.cells()).map(|cell| room.cost(clearance.at(cell))).collect();
        let mut costs = vec![f64::INFINITY; frame.cells()];
        let mut from: Vec<usize> = (0..frame.cells()).collect();
        let mut open = BinaryHeap::new();
        if weight[start].is_finite() {
            costs[start] = 0.0;
            open.push(Reverse((0_u64, start)));
        }
        while let Some(Reverse((bits, cell))) = open.pop() {
            // Costs are not negative, so their bits are in their order.
            if costs[cell].to_bits() != bits {
                continue;
            }
            for (dx, dy) in NEIGHBOURS {
                let Some(next) = frame.beside(cell, (dx, dy)) else { continue };
                let length_m = if dx * dy == 0 { 1.0 } else { std::f64::consts::SQRT_2 };
                let step = 0.5 * (weight[cell] + weight[next]) * length_m * frame.cell_m;
                let cost = costs[cell] + step;
                if cost < costs[next] {
                    costs[next] = cost;
                    from[next] = cell;
                    open.push(Reverse((cost.to_bits(), next)));
                }
            }
        }
        Self { start, costs, from }
    }

    /// What the way to a cell costs; infinite where there is none.
    pub fn cost(&self, cell: usize) -> f64 {
        self.costs[cell]
    }

    /// The cells of the way to a cell, both ends included; empty where there is
    /// none.
    pub fn cells_to(&self, cell: usize) -> Vec<usize> {
        if !self.costs[cell].is_finite() {
            return Vec::new();
        }
        let mut cells = vec![cell];
        let mut at = cell;
        while at != self.start {
            at = self.from[at];
            cells.push(at);
        }
        cells.reverse();
        cells
    }
}

/// The cell with enough room nearest to a point, no farther than `within_m`.
pub fn nearest_free(
    clearance: &Clearance,
    room: &Room,
    point: Point2<f64>,
    within_m: f64,
) -> Option<usize> {
    let frame = clearance.frame;
    let (column, row) = frame.column_row(point);
    let reach = (within_m / frame.cell_m).ceil() as i64;
    let around = |at: i64| at.saturating_sub(reach)..=at.saturating_add(reach);
    let cells = around(row).flat_map(|r| around(column).filter_map(move |c| frame.index(c, r)));
    let free = cells.filter(|cell| clearance.at(*cell) >= room.needed_m);
    let with_distance = free.map(|cell| ((frame.centre(cell) - point).norm(), cell));
    let near = with_distance.filter(|(distance_m, _)| *distance_m <= within_m + frame.cell_m);
    near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, cell)| cell)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::clearance::Unknown;
    use crate::{Cell, GridFrame, OccupancyMap, Random};
    use rusty_geometry::apartment;

    const ROOM: Room = Room { needed_m: 0.15, liked_m: 0.5, dislike: 4.0 };

    /// Costs by relaxing every step until nothing changes (Bellman and Ford).
    fn by_brute_force(clearance: &Clearance, room: &Room, start: usize) -> Vec<f64> {
        let frame = clearance.frame;
        let weight = |cell: usize| room.cost(clearance.at(cell));
        let mut costs = vec![f64::INFINITY; frame.cells()];
        costs[start] = if weight(start).is_finite() { 0.0 } else { f64::INFINITY };
        let mut changed = true;
        while changed {
            changed = false;
            for a in 0..frame.cells() {
                for b in 0..frame.cells() {
                    let between = (frame.centre(a) - frame.centre(b)).norm();
                    if a != b && between < 1.5 * frame.cell_m {
                        let cost = costs[a] + 0.5 * (weight(a) + weight(b)) * between;
                        if cost < costs[b] - 1e-12 {
                            (costs[b], changed) = (cost, true);
                        }
                    }
                }
            }
        }
        costs
    }

    #[test]
    fn costs_are_those_of_trying_everything() {
        let mut random = Random::new(2, 1);
        let mut reached = 0;
        for _ in 0..12 {
            let origin_m = Point2::new(0.0, 0.0);
            let frame = GridFrame { origin_m, cell_m: 0.1, width: 11, height: 9 };
            let wall = |u: f64| if u < 0.12 { Cell::Occupied } else { Cell::Free };
            let cells = (0..frame.cells()).map(|_| wall(random.uniform())).collect();
            let clearance = Clearance::of_map(&OccupancyMap { frame, cells }, Unknown::Wall);
            let room = Room { needed_m: 0.05, liked_m: 0.3, dislike: 3.0 };
            let start = (random.uniform() * frame.cells() as f64) as usize;
            let routes = Routes::new(&clearance, &room, start);
            for (cell, cost) in by_brute_force(&clearance, &room, start).into_iter().enumerate() {
                let found = routes.cost(cell);
                assert!(found == cost || (found - cost).abs() < 1e-9, "{found} for {cost}");
                let way = routes.cells_to(cell);
                assert_eq!(way.is_empty(), cost.is_infinite());
                if let (Some(first), Some(last)) = (way.first(), way.last()) {
                    reached += 1;
                    assert_eq!((*first, *last), (start, cell));
                    let steps = way.windows(2).map(|w| frame.centre(w[0]) - frame.centre(w[1]));
                    assert!(steps.into_iter().all(|step| step.norm() < 0.15));
                }
            }
        }
        assert!(reached > 500, "{reached}");
    }

    #[test]
    fn every_room_of_the_apartment_is_reached_clear_of_the_walls() {
        let world = apartment();
        let map = OccupancyMap::of_world(&world, 0.1, 0.05);
        let clearance = Clearance::of_map(&map, Unknown::Wall);
        let frame = map.frame;
        let start = frame.cell_at(Point2::new(6.0, 4.5)).unwrap();
        let routes = Routes::new(&clearance, &ROOM, start);
        for (x, y) in [(1.8, 7.0), (5.4, 7.0), (1.3, 2.5), (4.9, 2.5), (9.6, 3.0), (10.0, 7.5)] {
            let way = routes.cells_to(frame.cell_at(Point2::new(x, y)).unwrap());
            assert!(way.len() > 20, "({x}, {y}) is not reached");
            for cell in way {
                let distance_m = world.distance_to_nearest(frame.centre(cell));
                // A cell's wall is at most half a diagonal from its centre.
                assert!(distance_m > ROOM.needed_m - 0.036, "{distance_m} m from a wall");
            }
        }
        // Behind the wardrobe's door, and beyond the walls, is nowhere.
        for (x, y) in [(3.2, 8.7), (-0.08, -0.08)] {
            assert!(routes.cells_to(frame.cell_at(Point2::new(x, y)).unwrap()).is_empty());
        }
    }

    #[test]
    fn who_stands_too_near_to_a_wall_is_led_off_it() {
        let clearance =
            Clearance::of_map(&OccupancyMap::of_world(&apartment(), 0.1, 0.05), Unknown::Wall);
        let at = Point2::new(6.0, 3.95);
        let free = nearest_free(&clearance, &ROOM, at, 0.4).unwrap();
        let off = clearance.frame.centre(free) - at;
        assert!(off.y > 0.05 && off.norm() < 0.2, "{off}");
        assert_eq!(nearest_free(&clearance, &ROOM, Point2::new(50.0, 0.0), 0.4), None);
        assert_eq!(nearest_free(&clearance, &ROOM, Point2::new(f64::NAN, 0.0), 0.4), None);
    }
}
