//! A scan against one ray at a time: the same bits, whatever the world, the pose
//! and the beams, on every way of computing it.
#![allow(clippy::unwrap_used)]

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{Point2, Vector2};
use proptest::prelude::*;
use rusty_geometry::{
    Fan, Material, SE2, Scan, WallSpec, World, WorldSpec, apartment, hallway, open, trig,
};

const FULL: Fan = Fan { first_bearing_rad: -PI, fov_rad: TAU, beams: 180 };

fn world_of(walls: &[([f64; 2], [f64; 2])]) -> World {
    let walls = walls.iter().map(|(a, b)| WallSpec { a: *a, b: *b, material: Material::Wall });
    World::new(WorldSpec {
        name: "test".to_owned(),
        bounds: [-1000.0, -1000.0, 1000.0, 1000.0],
        walls: walls.collect(),
        landmarks: Vec::new(),
    })
    .unwrap()
}

/// Bits of the distance, and the wall: what one ray at a time finds.
fn by_rays(world: &World, fan: &Fan, pose: &SE2, max_m: f64) -> Vec<(u64, Option<usize>)> {
    let (s, c) = trig::sin_cos(pose.theta());
    let origin = Point2::from(pose.translation());
    let ray = |k| {
        let beam = fan.direction(k);
        let along = Vector2::new(c * beam.x - s * beam.y, s * beam.x + c * beam.y);
        world
            .first_wall(origin, along, max_m)
            .map_or((max_m.to_bits(), None), |(t, wall)| (t.to_bits(), Some(wall)))
    };
    (0..fan.beams).map(ray).collect()
}

/// Takes a scan in both ways and compares every beam; returns how many hit.
fn check(world: &World, fan: Fan, pose: &SE2, max_m: f64) -> usize {
    let expected = by_rays(world, &fan, pose, max_m);
    for mut scan in [Scan::new(fan), Scan::portable(fan)] {
        // The second one must not see what the first one left behind.
        for _ in 0..2 {
            scan.take(world, pose, max_m);
            let found: Vec<_> =
                scan.distances_and_walls().map(|(t, wall)| (t.to_bits(), wall)).collect();
            for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
                assert_eq!(found, expected, "beam {k} of {fan:?} at {pose:?} up to {max_m} m");
            }
            assert_eq!(found.len(), fan.beams as usize);
            // Into slices that are shorter, as long, and longer.
            for length in [found.len() - 1, found.len(), found.len() + 5] {
                let mut distances_m = vec![-1.0; length];
                scan.write_distances_m(&mut distances_m);
                let written = distances_m.iter().zip(found.iter().map(|(t, _)| f64::from_bits(*t)));
                assert!(written.clone().all(|(a, b)| a.to_bits() == b.to_bits()));
                assert!(distances_m.iter().skip(found.len()).all(|a| *a == -1.0));
            }
        }
    }
    expected.iter().filter(|(_, wall)| wall.is_some()).count()
}

#[test]
fn the_places_of_the_book() {
    for (world, least) in [(apartment(), 1), (hallway(), 1), (open(), 0)] {
        let [x_min, y_min, x_max, y_max] = world.bounds();
        let mut hits = 0;
        for k in 0..300 {
            let part = |n: u32| f64::from(k * n % 301) / 300.0;
            let (x, y) = (x_min + (x_max - x_min) * part(7), y_min + (y_max - y_min) * part(11));
            let pose = SE2::new(x, y, part(13) * TAU - PI);
            let beams = [1, 2, 3, 4, 5, 31, 180, 1080][k as usize % 8];
            hits += check(&world, Fan { beams, ..FULL }, &pose, 0.5 + 20.0 * part(3));
        }
        assert!(hits >= 10_000 * least, "{}: {hits}", world.name());
    }
}

#[test]
fn from_corners_and_along_walls() {
    // Axis-parallel beams from the corners of an axis-parallel plan: rays through
    // vertices, rays along walls, sensors on walls and at their ends.
    let world = apartment();
    for wall in world.walls() {
        let middle = nalgebra::center(&wall.a, &wall.b);
        for point in [wall.a, wall.b, middle] {
            for (dx, dy) in [(0.0, 0.0), (-0.5, 0.0), (1.25, 0.0), (0.0, 0.75), (1e-7, -1e-9)] {
                for theta in [0.0, FRAC_PI_2, PI, -FRAC_PI_2, 0.3] {
                    let pose = SE2::new(point.x + dx, point.y + dy, theta);
                    check(&world, Fan { first_bearing_rad: 0.0, beams: 36, ..FULL }, &pose, 8.0);
                }
            }
        }
    }
}

#[test]
fn no_walls_and_poses_that_are_no_poses() {
    let mut scan = Scan::new(FULL);
    scan.take(&open(), &SE2::new(1.0, 2.0, 3.0), 8.0);
    assert!(scan.distances_and_walls().all(|met| met == (8.0, None)));
    for (x, y) in [(f64::NAN, 0.0), (0.0, f64::INFINITY), (f64::MAX, 0.0), (-3e9, 0.0)] {
        check(&apartment(), FULL, &SE2::new(x, y, 0.0), 1e12);
    }
    assert_eq!(check(&apartment(), FULL, &SE2::new(6.0, 4.5, 0.0), f64::INFINITY), 180);
}

#[test]
fn a_wall_at_exactly_the_maximum_is_met() {
    let world = world_of(&[([2.0, -1.0], [2.0, 1.0]), ([2.0, -1.0], [2.0, 1.0])]);
    let ahead = Fan { first_bearing_rad: 0.0, fov_rad: 1.0, beams: 1 };
    let mut scan = Scan::new(ahead);
    for (max_m, wall) in [(2.0, Some(0)), (2.0_f64.next_down(), None)] {
        scan.take(&world, &SE2::identity(), max_m);
        assert_eq!(scan.distances_and_walls().next(), Some((max_m, wall)));
        check(&world, ahead, &SE2::identity(), max_m);
    }
}

/// Up to 250 walls that keep clear of each other, one per cell of a grid.
fn clear_walls() -> impl Strategy<Value = World> {
    let wall = (prop::array::uniform4(0.1_f64..0.9), any::<bool>());
    (prop::collection::vec(wall, 1..250), 0.2_f64..5.0).prop_map(|(walls, cell_m)| {
        let cell = |(index, ([ax, ay, bx, by], there)): (usize, ([f64; 4], bool))| {
            let (x, y) = ((index % 16) as f64 - 8.0, (index / 16) as f64 - 8.0);
            let at = |dx: f64, dy: f64| [(x + dx) * cell_m, (y + dy) * cell_m];
            there.then_some((at(ax, ay), at(bx, by)))
        };
        let walls: Vec<_> = walls.into_iter().enumerate().filter_map(cell).collect();
        // Walls may be too short or too close; then there is one that is not.
        let spec = walls.iter().map(|(a, b)| WallSpec { a: *a, b: *b, material: Material::Wall });
        World::new(WorldSpec {
            name: "clear".to_owned(),
            bounds: [-100.0, -100.0, 100.0, 100.0],
            walls: spec.collect(),
            landmarks: Vec::new(),
        })
        .unwrap_or_else(|_| world_of(&[([2.0, -1.0], [2.0, 1.0])]))
    })
}

/// Edges and diagonals of a lattice: shared ends, T junctions, crossings,
/// collinear neighbours, walls twice.
fn lattice() -> impl Strategy<Value = World> {
    let wall = (-5_i8..5, -5_i8..5, -3_i8..=3, -3_i8..=3);
    prop::collection::vec(wall, 1..120).prop_map(|walls| {
        let walls = walls.into_iter().filter(|(_, _, dx, dy)| (*dx, *dy) != (0, 0));
        let walls: Vec<_> = walls
            .map(|(x, y, dx, dy)| {
                let at = |x: i8, y: i8| [f64::from(x), f64::from(y)];
                (at(x, y), at(x + dx, y + dy))
            })
            .chain([([-5.0, -5.0], [5.0, -5.0])])
            .collect();
        world_of(&walls)
    })
}

fn any_fan() -> impl Strategy<Value = Fan> {
    let fov_rad = prop_oneof![Just(TAU), 1e-6_f64..TAU, Just(PI), Just(1e-6)];
    let first_rad = prop_oneof![Just(-PI), Just(0.0), -TAU..TAU];
    (first_rad, fov_rad, 1_u32..300).prop_map(|(first_bearing_rad, fov_rad, beams)| Fan {
        first_bearing_rad,
        fov_rad,
        beams,
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn walls_anywhere(
        world in clear_walls(),
        fan in any_fan(),
        [x, y] in prop::array::uniform2(-10.0_f64..10.0),
        theta in -3.2_f64..3.2,
        max_m in 0.1_f64..30.0,
    ) {
        check(&world, fan, &SE2::new(x, y, theta), max_m);
        // At the first wall's ends and on it, and looking straight at an end.
        if let Some(wall) = world.walls().first() {
            check(&world, fan, &SE2::new(wall.a.x, wall.a.y, theta), max_m);
            let middle = nalgebra::center(&wall.a, &wall.b);
            check(&world, fan, &SE2::new(middle.x, middle.y, theta), max_m);
            let bearing_rad = trig::atan2(wall.b.y - y, wall.b.x - x);
            for ulps in [bearing_rad.next_down(), bearing_rad, bearing_rad.next_up()] {
                let straight = Fan { first_bearing_rad: 0.0, ..fan };
                check(&world, straight, &SE2::new(x, y, ulps), max_m);
            }
        }
    }

    #[test]
    fn walls_on_a_lattice(
        world in lattice(),
        fan in any_fan(),
        [x, y] in prop::array::uniform2(-6_i8..=6),
        [dx, dy] in prop::array::uniform2(prop_oneof![Just(0.0), Just(0.5), -1e-9_f64..1e-9, 0.0_f64..1.0]),
        turns in 0_u8..4,
        max_m in 0.5_f64..12.0,
    ) {
        let theta = f64::from(turns) * FRAC_PI_2;
        let pose = SE2::new(f64::from(x) + dx, f64::from(y) + dy, theta);
        check(&world, fan, &pose, max_m);
        check(&world, Fan { first_bearing_rad: 0.0, fov_rad: TAU, beams: 8 }, &pose, max_m.ceil());
    }
}
