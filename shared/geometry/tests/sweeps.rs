//! The swept disc against dense sampling, and the cases sampling gets wrong.
#![allow(clippy::unwrap_used)]

use core::f64::consts::PI;

use nalgebra::{Point2, Vector3};
use proptest::prelude::*;
use rusty_geometry::{Material, MotionArc, SE2, Wall, WallSpec, World, WorldSpec, apartment, open};

fn wall(a: [f64; 2], b: [f64; 2]) -> Wall {
    Wall { a: Point2::from(a), b: Point2::from(b), material: Material::Wall }
}

fn world_of(a: [f64; 2], b: [f64; 2]) -> World {
    World::new(WorldSpec {
        name: "one wall".to_owned(),
        bounds: [-1e5, -1e5, 1e5, 1e5],
        walls: vec![WallSpec { a, b, material: Material::Wall }],
        landmarks: Vec::new(),
    })
    .unwrap()
}

/// Least distance over samples of the motion itself, and the spacing of them.
fn by_sampling(from: &SE2, to: &SE2, wall: &Wall) -> (f64, f64) {
    const STEPS: u32 = 2000;
    let tau = to.boxminus(from);
    let least_m = (0..=STEPS)
        .map(|k| from.boxplus(&(tau * (f64::from(k) / f64::from(STEPS)))))
        .map(|pose| wall.distance(&Point2::new(pose.x(), pose.y())))
        .fold(f64::INFINITY, f64::min);
    let length_m = (tau.x * tau.x + tau.y * tau.y).sqrt();
    (least_m, length_m / f64::from(STEPS))
}

#[test]
fn a_fast_body_does_not_tunnel() {
    let world = world_of([1.0, -5.0], [1.0, 5.0]);
    let radius_m = 0.11;
    for turn_rad in [0.0, 1e-300, 1e-17, 1e-12, 1e-8, 1e-4, 0.5, PI] {
        for turn_rad in [turn_rad, -turn_rad] {
            for y in [0.0, 0.7] {
                let from = SE2::new(0.0, 0.0, 0.3 - 0.5 * turn_rad);
                let to = SE2::new(2.0, y, 0.3 + 0.5 * turn_rad);
                assert!(!world.blocks(&from, &from, radius_m));
                assert!(!world.blocks(&to, &to, radius_m));
                assert!(world.blocks(&from, &to, radius_m), "turn {turn_rad}");
                assert!(world.blocks(&to, &from, radius_m), "turn {turn_rad}");
                assert!(world.blocks(&from, &to, 0.0), "turn {turn_rad}");
            }
        }
    }
}

#[test]
fn the_belly_of_an_arc_touches_what_its_chord_does_not() {
    // Half a turn to the left from (0, 0) to (0, 2): the path bulges to x = 1.
    let (from, to) = (SE2::new(0.0, 0.0, 0.0), SE2::new(0.0, 2.0, PI));
    let beside = |x: f64| world_of([x, 0.95], [x, 1.05]);
    assert!(beside(1.10).blocks(&from, &to, 0.11));
    assert!(!beside(1.12).blocks(&from, &to, 0.11));
    assert!(!beside(0.88).blocks(&from, &to, 0.11), "inside the turn");
    assert!(beside(0.90).blocks(&from, &to, 0.11));
    assert!(!beside(-0.2).blocks(&from, &to, 0.11), "the other half of the circle");
    let length_m = MotionArc::between(&from, &to).length_m();
    assert!((length_m - PI).abs() < 1e-15);
}

#[test]
fn a_sideways_tangent_is_swept_along_its_own_path() {
    let from = SE2::new(0.0, 0.0, 0.0);
    let to = from.boxplus(&Vector3::new(0.0, 2.0, 0.0));
    assert!(world_of([-1.0, 1.0], [1.0, 1.0]).blocks(&from, &to, 0.1));
    assert!(!world_of([1.0, 0.0], [1.0, 2.0]).blocks(&from, &to, 0.1));
}

#[test]
fn turning_on_the_spot_is_free_wherever_standing_is() {
    let world = apartment();
    for i in 0..60 {
        for j in 0..45 {
            let (x, y) = (0.2 * f64::from(i) + 0.013, 0.2 * f64::from(j) + 0.007);
            let stands = SE2::new(x, y, 0.4);
            let blocked = world.distance_to_nearest(Point2::new(x, y)) < 0.11;
            assert_eq!(world.blocks(&stands, &stands, 0.11), blocked);
            for turn_rad in [1e-9, -0.3, 2.0, PI] {
                let turned = stands.boxplus(&Vector3::new(0.0, 0.0, turn_rad));
                assert_eq!(world.blocks(&stands, &turned, 0.11), blocked, "{x} {y}");
            }
        }
    }
}

#[test]
fn exactly_the_radius_is_no_touch() {
    let world = world_of([0.0, 0.5], [10.0, 0.5]);
    let (from, to) = (SE2::new(1.0, 0.25, 0.0), SE2::new(2.0, 0.25, 0.0));
    assert!(!world.blocks(&from, &to, 0.25));
    assert!(world.blocks(&from, &to, 0.25_f64.next_up()));
    assert!(!world.blocks(&from, &to, 0.0));
}

#[test]
fn a_body_that_touches_is_blocked_even_moving_away() {
    let world = world_of([0.0, -1.0], [0.0, 1.0]);
    assert!(world.blocks(&SE2::new(0.1, 0.0, 0.0), &SE2::new(0.5, 0.0, 0.0), 0.11));
}

#[test]
fn nowhere_is_blocked_and_the_open_plane_is_free() {
    let (from, to) = (SE2::identity(), SE2::new(500.0, 3.0, -2.0));
    assert!(!open().blocks(&from, &to, 0.11));
    assert!(open().blocks(&from, &SE2::new(f64::NAN, 0.0, 0.0), 0.11));
    assert!(open().blocks(&SE2::new(0.0, 0.0, f64::INFINITY), &to, 0.11));
    for radius_m in [f64::NAN, -0.1, f64::INFINITY] {
        assert!(open().blocks(&from, &to, radius_m));
    }
}

#[test]
fn nearly_straight_arcs_agree_with_the_straight_one() {
    // Five metres from a wall, with curvatures down to nothing.
    let beside = wall([-20.0, 0.3], [30.0, 0.3]);
    let short = wall([2.0, 0.3], [2.5, 0.9]);
    let from = SE2::new(0.0, 0.0, 0.0);
    for turn_rad in [1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 1e-18, 1e-300, 0.0] {
        for turn_rad in [turn_rad, -turn_rad] {
            let to = from.boxplus(&Vector3::new(5.0, 0.0, turn_rad));
            let arc = MotionArc::between(&from, &to);
            for wall in [&beside, &short] {
                let off_m = (arc.distance(wall) - 0.3).abs();
                assert!(off_m <= 2.5 * turn_rad.abs() + 1e-15, "{turn_rad}: {off_m:e}");
            }
        }
    }
}

fn any_pose() -> impl Strategy<Value = SE2> {
    (-3.0_f64..3.0, -3.0_f64..3.0, -PI..PI).prop_map(|(x, y, theta)| SE2::new(x, y, theta))
}

/// Twists of every kind: sideways parts, tiny turns, tiny steps, half turns.
fn any_twist() -> impl Strategy<Value = Vector3<f64>> {
    let turn_rad = prop_oneof![
        -3.1_f64..3.1,
        (-18.0_f64..0.0, any::<bool>()).prop_map(|(e, left)| {
            let size = rusty_geometry::trig::exp(e * core::f64::consts::LN_10);
            if left { size } else { -size }
        }),
        Just(PI),
        Just(0.0),
    ];
    let size_m = prop_oneof![-4.0_f64..4.0, -0.05_f64..0.05, Just(0.0)];
    (size_m.clone(), size_m, turn_rad).prop_map(|(x, y, theta)| Vector3::new(x, y, theta))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 1500, ..ProptestConfig::default() })]

    #[test]
    fn the_exact_distance_agrees_with_sampling(
        from in any_pose(),
        tau in any_twist(),
        a in prop::array::uniform2(-5.0_f64..5.0),
        b in prop::array::uniform2(-5.0_f64..5.0),
        radius_m in 0.0_f64..1.5,
    ) {
        let to = from.boxplus(&tau);
        let wall = wall(a, b);
        prop_assume!(wall.length_m() > 1e-3);
        let exact_m = MotionArc::between(&from, &to).distance(&wall);
        let (sampled_m, spacing_m) = by_sampling(&from, &to, &wall);
        prop_assert!(exact_m <= sampled_m + 1e-12, "exact {exact_m}, sampled {sampled_m}");
        prop_assert!(exact_m >= sampled_m - 0.51 * spacing_m - 1e-12, "exact {exact_m}, sampled {sampled_m}");
        let blocked = world_of(a, b).blocks(&from, &to, radius_m);
        prop_assert_eq!(blocked, exact_m < radius_m || exact_m == 0.0);
    }

    #[test]
    fn walls_along_the_path_agree_with_sampling(
        from in any_pose(),
        tau in any_twist(),
        along in prop::array::uniform2(-6.0_f64..6.0),
        beside_m in -1.0_f64..1.0,
        tilt_m in prop_oneof![Just(0.0), -1e-9_f64..1e-9, -0.1_f64..0.1],
    ) {
        let to = from.boxplus(&tau);
        let offset = |x: f64, y: f64| {
            let point = from.transform_point(&Point2::new(x, y));
            [point.x, point.y]
        };
        let wall = wall(offset(along[0], beside_m), offset(along[1], beside_m + tilt_m));
        prop_assume!(wall.length_m() > 1e-3);
        let exact_m = MotionArc::between(&from, &to).distance(&wall);
        let (sampled_m, spacing_m) = by_sampling(&from, &to, &wall);
        prop_assert!(exact_m <= sampled_m + 1e-12, "exact {exact_m}, sampled {sampled_m}");
        prop_assert!(exact_m >= sampled_m - 0.51 * spacing_m - 1e-12, "exact {exact_m}, sampled {sampled_m}");
    }

    #[test]
    fn there_and_back_is_the_same_path(
        from in any_pose(),
        tau in any_twist(),
        a in prop::array::uniform2(-5.0_f64..5.0),
        b in prop::array::uniform2(-5.0_f64..5.0),
    ) {
        // At exactly half a turn the way back bulges to the other side.
        let tau = if tau.z == PI { tau * 0.99 } else { tau };
        let to = from.boxplus(&tau);
        let wall = wall(a, b);
        prop_assume!(wall.length_m() > 1e-3);
        let there_m = MotionArc::between(&from, &to).distance(&wall);
        let back_m = MotionArc::between(&to, &from).distance(&wall);
        prop_assert!((there_m - back_m).abs() < 1e-11, "{there_m} {back_m}");
    }

    #[test]
    fn the_arc_is_the_motion(from in any_pose(), tau in any_twist(), fraction in 0.0_f64..=1.0) {
        let to = from.boxplus(&tau);
        let point = MotionArc::between(&from, &to).point(fraction);
        let pose = from.boxplus(&(to.boxminus(&from) * fraction));
        prop_assert!((point.x - pose.x()).abs() < 1e-11);
        prop_assert!((point.y - pose.y()).abs() < 1e-11);
    }
}
