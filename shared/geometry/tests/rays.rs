//! Rays in the places of the book: watertight walls, materials, ties, and the
//! tree against every wall in turn.
#![allow(clippy::unwrap_used)]

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{Point2, Vector2};
use proptest::prelude::*;
use rusty_geometry::generated::{Density, Pattern, Recipe};
use rusty_geometry::{
    Hit, Material, Wall, WallSpec, World, WorldSpec, apartment, hallway, open, trig,
};

/// Asks every wall in turn: nearest first, then lowest index.
fn by_scan(
    world: &World,
    origin: Point2<f64>,
    dir: Vector2<f64>,
    max_m: f64,
) -> Option<(f64, usize)> {
    let mut best: Option<(f64, usize)> = None;
    for (index, wall) in world.walls().iter().enumerate() {
        if let Some(t) = wall.cast(&origin, &dir)
            && t <= max_m
            && best.is_none_or(|(so_far, _)| t < so_far)
        {
            best = Some((t, index));
        }
    }
    best
}

fn unit(angle_rad: f64) -> Vector2<f64> {
    let (s, c) = trig::sin_cos(angle_rad);
    Vector2::new(c, s)
}

fn world_of(walls: &[([f64; 2], [f64; 2])]) -> World {
    let walls = walls.iter().map(|(a, b)| WallSpec { a: *a, b: *b, material: Material::Wall });
    World::new(WorldSpec {
        name: "test".to_owned(),
        bounds: [-100.0, -100.0, 100.0, 100.0],
        walls: walls.collect(),
        landmarks: Vec::new(),
    })
    .unwrap()
}

/// Points of a grid inside the bounds that are not on a wall. `below_y_m` cuts
/// off the recesses of the Hallway's doors, next to which lies the outside.
fn inside_points(world: &World, below_y_m: f64) -> Vec<Point2<f64>> {
    let [x_min, y_min, x_max, y_max] = world.bounds();
    let (n_x, n_y) = (24, 17);
    let mut points = Vec::new();
    for i in 1..n_x {
        for j in 1..n_y {
            let x = x_min + (x_max - x_min) * (f64::from(i) + 0.137) / f64::from(n_x + 1);
            let y = y_min + (y_max.min(below_y_m) - y_min) * f64::from(j) / f64::from(n_y);
            let point = Point2::new(x, y);
            if world.distance_to_nearest(point) > 1e-6 {
                points.push(point);
            }
        }
    }
    points
}

#[test]
fn both_worlds_are_watertight() {
    for (world, below_y_m) in [(hallway(), 1.6), (apartment(), 9.0)] {
        let points = inside_points(&world, below_y_m);
        assert!(points.len() > 300, "{}", points.len());
        for point in points {
            for k in 0..360 {
                let angle_rad = TAU * f64::from(k) / 360.0;
                let hit = world.raycast(point, angle_rad, 100.0);
                assert!(hit.material.is_some(), "{}: {point} at {angle_rad}", world.name());
            }
            for vertex in world.walls().iter().flat_map(|wall| [wall.a, wall.b]) {
                let to = vertex - point;
                let aimed = [
                    to / trig::hypot(to.x, to.y),
                    unit(trig::atan2(to.y, to.x)),
                    unit(trig::atan2(to.y, to.x).next_up()),
                    unit(trig::atan2(to.y, to.x).next_down()),
                ];
                for dir in aimed {
                    let found = world.first_wall(point, dir, 100.0);
                    assert!(found.is_some(), "{}: {point} at vertex {vertex}", world.name());
                    assert_eq!(found, by_scan(&world, point, dir, 100.0));
                }
            }
        }
    }
}

#[test]
fn materials_of_the_places() {
    let world = hallway();
    for (x, door) in [(2.0, 0), (4.6, 1), (9.0, 2)] {
        let hit = world.raycast(Point2::new(x, 0.8), FRAC_PI_2, 8.0);
        assert_eq!(hit.material, Some(Material::Door(door)));
        assert!((hit.distance_m - 0.9).abs() < 1e-15);
    }
    let south = world.raycast(Point2::new(2.0, 0.8), -FRAC_PI_2, 8.0);
    assert_eq!(south.material, Some(Material::Wall));
    let home = apartment();
    let cases = [
        ([9.6, 3.0], -FRAC_PI_2, Material::Glass),
        ([9.6, 4.5], 0.0, Material::Glass),
        ([6.0, 4.5], PI, Material::Door(0)),
        ([3.0, 7.0], FRAC_PI_2, Material::Door(1)),
        ([0.5, 2.0], -FRAC_PI_2, Material::Glass),
    ];
    for (from, angle_rad, material) in cases {
        let hit = home.raycast(Point2::from(from), angle_rad, 100.0);
        assert_eq!(hit.material, Some(material), "{from:?}");
    }
}

#[test]
fn the_maximum_is_inclusive_and_reported() {
    let world = world_of(&[([2.0, -1.0], [2.0, 1.0])]);
    let origin = Point2::new(0.0, 0.0);
    let miss = |distance_m| Hit { distance_m, material: None };
    assert_eq!(world.raycast(origin, 0.0, 2.0).material, Some(Material::Wall));
    assert_eq!(world.raycast(origin, 0.0, 2.0_f64.next_down()), miss(2.0_f64.next_down()));
    assert_eq!(world.raycast(origin, PI, f64::INFINITY), miss(f64::INFINITY));
    assert_eq!(open().raycast(origin, 0.0, 8.0), miss(8.0));
    for bad in [f64::NAN, f64::INFINITY] {
        assert_eq!(world.raycast(Point2::new(bad, 0.0), 0.0, 8.0), miss(8.0));
        assert_eq!(world.raycast(origin, bad, 8.0), miss(8.0));
    }
    assert!(world.first_wall(origin, unit(0.0), f64::NAN).is_none());
}

#[test]
fn at_equal_distance_the_lowest_index_wins() {
    // Three walls share the end (2, 0), two more lie on top of each other.
    let fan = [([2.0, 0.0], [3.0, 1.0]), ([2.0, 0.0], [3.0, -1.0]), ([4.0, 0.0], [2.0, 0.0])];
    let mut order = fan.to_vec();
    for _ in 0..3 {
        order.rotate_left(1);
        let found = world_of(&order).first_wall(Point2::new(0.0, 0.0), unit(0.0), 9.0);
        assert_eq!(found, Some((2.0, 0)));
    }
    let twice =
        world_of(&[([1.0, 5.0], [2.0, 5.0]), ([2.0, -1.0], [2.0, 1.0]), ([2.0, 1.0], [2.0, -1.0])]);
    assert_eq!(twice.first_wall(Point2::new(0.0, 0.3), unit(0.0), 9.0), Some((2.0, 1)));
    assert_eq!(twice.first_wall(Point2::new(2.0, 0.3), unit(1.0), 9.0), Some((0.0, 1)));
}

#[test]
fn from_very_far_away_every_wall_is_asked() {
    let world = world_of(&[([2.0, -1.0], [2.0, 1.0]), ([3.0, -1.0], [3.0, 1.0])]);
    let origin = Point2::new(-3e9, 0.0);
    assert_eq!(world.first_wall(origin, unit(0.0), 1e12), Some((3e9 + 2.0, 0)));
    assert_eq!(world.distance_to_nearest(origin), 3e9 + 2.0);
}

#[test]
fn distance_to_nearest_wall() {
    assert_eq!(open().distance_to_nearest(Point2::new(1.0, 2.0)), f64::INFINITY);
    assert!(hallway().distance_to_nearest(Point2::new(f64::NAN, 0.0)).is_nan());
    let nearest_m = hallway().distance_to_nearest(Point2::new(6.0, 0.5));
    assert!((nearest_m - 0.5).abs() < 1e-15);
    assert_eq!(apartment().distance_to_nearest(Point2::new(7.2, 2.0)), 0.0);
}

/// Few walls are looked at one by one, many by the tree.
#[test]
fn a_wedge_leaves_out_no_wall_that_reaches_into_it() {
    for walls in [40, 2000] {
        let recipe = Recipe { pattern: Pattern::Segments, density: Density::Area, walls, seed: 3 };
        let world = World::new(recipe.spec()).unwrap();
        let mut found = 0;
        for k in 0..400 {
            let apex = Point2::new(0.13 * f64::from(k), 64.0 - 0.15 * f64::from(k));
            let (middle_rad, half_rad) = (0.37 * f64::from(k), 0.02 + 0.001 * f64::from(k));
            let (right, left) = (unit(middle_rad - half_rad), unit(middle_rad + half_rad));
            let sides = [Vector2::new(-right.y, right.x), Vector2::new(left.y, -left.x)];
            // The nearest of 33 points of a wall that is in the wedge.
            let measure = |wall: &Wall| {
                let at = (0..=32).map(|i| wall.a + (wall.b - wall.a) * (f64::from(i) / 32.0));
                let within =
                    at.map(|at| at - apex).filter(|to| sides.iter().all(|s| s.dot(to) >= 0.0));
                within.map(|to| to.dot(&to)).reduce(f64::min)
            };
            let expected = world.walls().iter().filter_map(measure).fold(400.0, f64::min);
            assert_eq!(world.least_squared_in_wedge(apex, &sides, 400.0, measure), expected);
            assert_eq!(world.least_squared(apex, 400.0, measure), expected);
            found += u32::from(expected < 400.0);
        }
        assert!((20..400).contains(&found), "{walls}: {found}");
    }
}

/// Up to sixty walls that keep clear of each other: one per cell of a grid.
fn any_world() -> impl Strategy<Value = World> {
    let wall = (0.1_f64..0.9, 0.1_f64..0.9, 0.1_f64..0.9, 0.1_f64..0.9, any::<bool>());
    prop::collection::vec(wall, 1..60).prop_map(|walls| {
        let cell = |(index, (ax, ay, bx, by, there)): (usize, (f64, f64, f64, f64, bool))| {
            let (x, y) = ((index % 8) as f64 - 4.0, (index / 8) as f64 - 4.0);
            there.then_some(([x + ax, y + ay], [x + bx, y + by]))
        };
        let walls: Vec<_> = walls.into_iter().enumerate().filter_map(cell).collect();
        world_of(&walls)
    })
}

/// Every wall on a ray within reach, by distance and then by index.
fn all_by_scan(
    world: &World,
    origin: Point2<f64>,
    dir: Vector2<f64>,
    max_m: f64,
) -> Vec<(f64, usize)> {
    let walls = world.walls().iter().enumerate();
    let hits = walls.filter_map(|(index, wall)| Some((wall.cast(&origin, &dir)?, index)));
    let mut hits: Vec<_> = hits.filter(|(t, _)| *t <= max_m).collect();
    hits.sort_by(|a, b| a.partial_cmp(b).unwrap());
    hits
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn wall_after_wall_gives_every_wall_on_the_ray_once(
        world in any_world(),
        origin in prop::array::uniform2(-6.0_f64..6.0),
        first_rad in -3.2_f64..3.2,
        max_m in 0.1_f64..20.0,
    ) {
        // Each wall a second time: ties.
        let mut spec = world.spec().clone();
        spec.walls.extend_from_within(..);
        let world = World::new(spec).unwrap();
        let far = Point2::new(2e7, origin[1]);
        for (k, origin) in (0..32).flat_map(|k| [(k, Point2::from(origin)), (k, far)]) {
            let dir = unit(first_rad + f64::from(k) * 0.2);
            let first = world.first_wall(origin, dir, max_m);
            let next = |hit: &(f64, usize)| world.next_wall(origin, dir, max_m, *hit);
            let all: Vec<_> = std::iter::successors(first, next).collect();
            prop_assert_eq!(all, all_by_scan(&world, origin, dir, max_m));
        }
    }

    #[test]
    fn the_tree_gives_the_bits_of_the_scan(
        world in any_world(),
        origin in prop::array::uniform2(-6.0_f64..6.0),
        first_rad in -3.2_f64..3.2,
        max_m in 0.1_f64..20.0,
    ) {
        let origin = Point2::from(origin);
        for k in 0..64 {
            let dir = unit(first_rad + f64::from(k) * 0.1);
            prop_assert_eq!(world.first_wall(origin, dir, max_m), by_scan(&world, origin, dir, max_m));
        }
        for dir in [Vector2::x(), -Vector2::x(), Vector2::y(), -Vector2::y()] {
            for wall in world.walls() {
                for origin in [wall.a, wall.b, wall.a - dir, wall.b - dir * 3.0] {
                    prop_assert_eq!(world.first_wall(origin, dir, max_m), by_scan(&world, origin, dir, max_m));
                }
            }
        }
        let least_m = world.walls().iter().map(|wall| wall.distance(&origin)).fold(f64::INFINITY, f64::min);
        prop_assert_eq!(world.distance_to_nearest(origin), least_m);
    }
}
