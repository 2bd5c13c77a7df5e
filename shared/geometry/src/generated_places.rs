//! Places that are hard for a filter, made by rule: a corridor and two rooms that repeat
//! themselves, and a workshop and a warehouse with furniture drawn from a seed.
//!
//! Portable arithmetic, so a seed gives the same bits everywhere.

use nalgebra::{Point2, Vector2};

use crate::generated::{Dice, wall};
use crate::trig;
use crate::world_spec::{WallSpec, WorldSpec};

/// Distance from one niche of the corridor to the next, metres.
const NICHE_EVERY_M: f64 = 4.0;
/// Number of niches of the corridor.
const NICHES: usize = 12;
/// Columns and rows of shelves in the warehouse: with the four walls around them
/// 4 + 4·31·33 = 4096 walls.
const SHELVES: [usize; 2] = [31, 33];
/// Distances from one shelf to the next, metres.
const SHELF_EVERY_M: [f64; 2] = [1.6, 1.9];
/// Number of things in the workshop.
const THINGS: usize = 70;
/// Space between two things, and from a thing to a wall, metres.
const THING_SPACE_M: f64 = 0.15;

/// A corridor of 48 m by 2 m with a niche every 4 m on its left side. From the middle
/// neither end is within 16 m.
#[must_use]
pub fn corridor() -> WorldSpec {
    let length_m = NICHE_EVERY_M * NICHES as f64;
    let mut corners = vec![[0.0, 0.0], [length_m, 0.0], [length_m, 2.0]];
    for niche in (0..NICHES).rev() {
        let x = NICHE_EVERY_M * niche as f64 + 1.5;
        corners.extend([[x + 1.0, 2.0], [x + 1.0, 2.3], [x, 2.3], [x, 2.0]]);
    }
    corners.push([0.0, 2.0]);
    spec("corridor", [length_m, 2.3], outline(&corners))
}

/// Two rooms of 5 m by 5 m with a passage between them, each the image of the other in
/// half a turn about (6, 2.5) m.
#[must_use]
pub fn twin_rooms() -> WorldSpec {
    let turned = |[x, y]: [f64; 2]| [12.0 - x, 5.0 - y];
    let room = [[5.0, 2.0], [5.0, 0.0], [0.0, 0.0], [0.0, 5.0], [5.0, 5.0], [5.0, 3.0], [7.0, 3.0]];
    let mut walls: Vec<WallSpec> = room.windows(2).map(|ends| wall(ends[0], ends[1])).collect();
    walls.extend(rectangle([0.4, 3.6], [1.2, 4.4]));
    walls.extend(rectangle([3.6, 0.6], [4.0, 1.0]));
    let others: Vec<WallSpec> = walls.iter().map(|w| wall(turned(w.a), turned(w.b))).collect();
    walls.extend(others);
    spec("twin-rooms", [12.0, 5.0], walls)
}

/// A hall of 12 m by 9 m with 70 boxes of 0.1 m to 0.8 m at all angles, none of them on
/// the way of a figure of eight about (6, 4.5) m whose circles have a radius of 0.83 m.
#[must_use]
pub fn workshop(seed: u64) -> WorldSpec {
    let (size, mut dice) = ([12.0, 9.0], Dice::new(seed));
    let mut walls = rectangle([0.0, 0.0], size);
    let mut things: Vec<(Point2<f64>, f64)> = Vec::new();
    // With this much room chance finds a place in some dozen draws.
    for _ in 0..1000 * THINGS {
        if things.len() == THINGS {
            break;
        }
        let half = [0.05 + 0.35 * dice.uniform(), 0.05 + 0.2 * dice.uniform()];
        let reach_m = trig::hypot(half[0], half[1]);
        let margin_m = reach_m + THING_SPACE_M;
        let at = size.map(|side_m| margin_m + (side_m - 2.0 * margin_m) * dice.uniform());
        let (at, turn_rad) = (Point2::from(at), core::f64::consts::PI * dice.uniform());
        let is_free = |(other, its_reach_m): &(Point2<f64>, f64)| {
            distance_m(&at, other) >= reach_m + its_reach_m + THING_SPACE_M
        };
        if is_off_the_eight(&at, reach_m) && things.iter().all(is_free) {
            things.push((at, reach_m));
            walls.extend(turned_box(&at, half, turn_rad));
        }
    }
    spec("workshop", size, walls)
}

/// Whether a thing leaves half a metre to either side of the figure of eight.
fn is_off_the_eight(at: &Point2<f64>, reach_m: f64) -> bool {
    const RADIUS_M: f64 = 0.5 / 0.6;
    [4.5 + RADIUS_M, 4.5 - RADIUS_M]
        .into_iter()
        .all(|y| (distance_m(at, &Point2::new(6.0, y)) - RADIUS_M).abs() >= reach_m + 0.5)
}

/// A hall of 51 m by 64 m with 1023 shelves of 0.8 m, 1.0 m or 1.2 m by 0.5 m, in rows 1.4 m
/// apart: 4096 walls.
#[must_use]
pub fn warehouse(seed: u64) -> WorldSpec {
    let mut dice = Dice::new(seed);
    let size =
        [SHELF_EVERY_M[0] * SHELVES[0] as f64 + 1.2, SHELF_EVERY_M[1] * SHELVES[1] as f64 + 1.0];
    let mut walls = rectangle([0.0, 0.0], size);
    for shelf in 0..SHELVES[0] * SHELVES[1] {
        let x = 0.8 + SHELF_EVERY_M[0] * (shelf % SHELVES[0]) as f64;
        let y = 1.2 + SHELF_EVERY_M[1] * (shelf / SHELVES[0]) as f64;
        let length_m = [0.8, 1.0, 1.2][(3.0 * dice.uniform()) as usize % 3];
        walls.extend(rectangle([x, y], [x + length_m, y + 0.5]));
    }
    spec("warehouse", size, walls)
}

fn spec(name: &str, [width, height]: [f64; 2], walls: Vec<WallSpec>) -> WorldSpec {
    let bounds = [0.0, 0.0, width, height];
    WorldSpec { name: name.to_owned(), bounds, walls, landmarks: Vec::new() }
}

/// The walls from each corner to the next, and from the last to the first.
fn outline(corners: &[[f64; 2]]) -> Vec<WallSpec> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| wall(*a, *b)).collect()
}

fn rectangle([x_a, y_a]: [f64; 2], [x_b, y_b]: [f64; 2]) -> Vec<WallSpec> {
    outline(&[[x_a, y_a], [x_b, y_a], [x_b, y_b], [x_a, y_b]])
}

/// A rectangle of these half sides about a point, turned.
fn turned_box(at: &Point2<f64>, [half_x, half_y]: [f64; 2], turn_rad: f64) -> Vec<WallSpec> {
    let (s, c) = trig::sin_cos(turn_rad);
    let corner = |u: f64, v: f64| {
        let corner = at + Vector2::new(c * u - s * v, s * u + c * v);
        [corner.x, corner.y]
    };
    outline(&[
        corner(-half_x, -half_y),
        corner(half_x, -half_y),
        corner(half_x, half_y),
        corner(-half_x, half_y),
    ])
}

fn distance_m(a: &Point2<f64>, b: &Point2<f64>) -> f64 {
    trig::hypot(a.x - b.x, a.y - b.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SE2, World};

    fn world(spec: WorldSpec) -> World {
        World::new(spec).unwrap()
    }

    /// The distances around a pose, in 60 directions.
    fn around(world: &World, pose: &SE2) -> Vec<f64> {
        let directions = (0..60).map(|k| pose.theta() + 0.1 * f64::from(k));
        let origin = Point2::from(pose.translation());
        directions.map(|rad| world.raycast(origin, rad, 8.0).distance_m).collect()
    }

    fn differ(a: &[f64], b: &[f64]) -> bool {
        a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-9)
    }

    #[test]
    fn the_corridor_repeats_itself_and_the_rooms_are_each_others_image() {
        let corridor = world(corridor());
        let at = |x: f64| around(&corridor, &SE2::new(x, 0.9, 0.2));
        for k in 0..5 {
            assert!(!differ(&at(16.3), &at(16.3 + 4.0 * f64::from(k))), "{k}");
        }
        assert!(differ(&at(16.3), &at(18.3)));
        let rooms = world(twin_rooms());
        for (x, y, theta) in [(2.2, 2.4, 0.4), (1.0, 0.7, -2.0), (6.0, 2.3, 1.0)] {
            let here = around(&rooms, &SE2::new(x, y, theta));
            let there = SE2::new(12.0 - x, 5.0 - y, theta + core::f64::consts::PI);
            assert!(!differ(&here, &around(&rooms, &there)), "({x}, {y})");
        }
        assert_eq!(rooms.walls().len(), 28);
    }

    #[test]
    fn a_seed_furnishes_a_hall_of_its_own() {
        for seed in 0..20 {
            let workshop = world(workshop(seed));
            assert_eq!(workshop.walls().len(), 4 * (THINGS + 1), "seed {seed}");
            assert_eq!(world(warehouse(seed)).walls().len(), 4096, "seed {seed}");
            for k in 0..63 {
                let (s, c) = trig::sin_cos(0.1 * f64::from(k));
                for side in [1.0, -1.0] {
                    let radius_m = 0.5 / 0.6;
                    let at = Point2::new(6.0 + radius_m * s, 4.5 + side * radius_m * (1.0 - c));
                    assert!(workshop.distance_to_nearest(at) > 0.45, "seed {seed}, {at}");
                }
            }
        }
        assert_ne!(workshop(1), workshop(2));
        assert_ne!(warehouse(1), warehouse(2));
        assert_eq!(warehouse(1), warehouse(1));
    }
}
