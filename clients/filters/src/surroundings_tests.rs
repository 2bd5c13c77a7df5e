//! The closed form compared with small steps, and the rule with the walls themselves.

use super::*;
use crate::Random;
use nalgebra::Vector3;
use rusty_contract::{LogHeader, Scenario};
use rusty_geometry::{Scan, World, apartment};

/// What a participant of a run with these beams is told.
pub(crate) fn start(world: &World, at: SE2) -> Start {
    let scenario = Scenario { seed: 1, start: at, ..Scenario::default() };
    let header = LogHeader::simulated("test", &scenario, world.spec().clone());
    Start::new(&header, 0, &header.roster[0])
}

/// Ranges without noise from a pose in the Apartment, m.
pub(crate) fn ranges_from(told: &Start, pose: &SE2) -> Vec<f64> {
    let mut scan = Scan::new(told.lidar.fan());
    scan.take(&apartment(), pose, told.lidar.range_max_m);
    let mut ranges_m = vec![0.0; told.lidar.beams as usize];
    scan.write_distances_m(&mut ranges_m);
    ranges_m
}

/// What a robot sees from a pose in the Apartment, without noise.
pub(crate) fn seen_from(pose: SE2) -> Surroundings {
    let told = start(&apartment(), pose);
    let mut around = Surroundings::new(&told, &Caution::default());
    around.tick(EncoderCounts::default(), Some(&ranges_from(&told, &pose)));
    around
}

#[test]
fn the_closed_form_is_where_small_steps_meet_the_point() {
    let mut random = Random::new(3, 1);
    let (mut met, mut inside) = (0, 0);
    for _ in 0..2000 {
        let between = |random: &mut Random, a: f64, b: f64| a + (b - a) * random.uniform();
        let point = Point2::new(between(&mut random, -0.6, 0.9), between(&mut random, -0.6, 0.6));
        let curvature_per_m = match random.uniform() {
            u if u < 0.2 => 0.0,
            _ => between(&mut random, -8.0, 8.0),
        };
        let radius_m = between(&mut random, 0.05, 0.4);
        let said_m = clear_along_m(point, curvature_per_m, radius_m);
        // A robot that is nearer already may not come any nearer.
        let limit_m = radius_m.min(point.coords.norm());
        inside += u32::from(limit_m < radius_m);
        let mut stepped_m = f64::INFINITY;
        // After one circle the way begins again.
        let round_m = std::f64::consts::TAU / curvature_per_m.abs().max(1e-9);
        let steps = 4000;
        let most_m = round_m.min(2.0);
        for k in 1..=steps {
            let way_m = most_m * f64::from(k) / f64::from(steps);
            let at = SE2::exp(&Vector3::new(way_m, 0.0, curvature_per_m * way_m));
            let distance_m = (point.coords - at.translation()).norm();
            if distance_m < limit_m - 1e-7 {
                stepped_m = way_m;
                break;
            }
        }
        if stepped_m.is_finite() {
            met += 1;
            // A point that is passed in the last 10⁻⁷ m is met late by steps.
            assert!(said_m < stepped_m && said_m > stepped_m - 0.03, "{said_m} for {stepped_m}");
        } else {
            let grazed = said_m < most_m - 0.03;
            assert!(!grazed, "{said_m}: {point} {curvature_per_m} {radius_m} {limit_m} is clear");
        }
    }
    assert!(met > 400 && inside > 150, "{met} {inside}");
}

#[test]
fn whatever_is_commanded_the_admissible_part_touches_nothing() {
    let world = apartment();
    let mut random = Random::new(5, 1);
    let (mut limited, mut stopped, mut tried) = (0, 0, 0);
    let told = start(&world, SE2::identity());
    let mut scan = Scan::new(told.lidar.fan());
    let mut ranges_m = vec![0.0; told.lidar.beams as usize];
    while tried < 3000 {
        let pose = SE2::new(
            12.0 * random.uniform(),
            9.0 * random.uniform(),
            std::f64::consts::TAU * random.uniform(),
        );
        if world.blocks(&pose, &pose, told.robot.body_radius_m) {
            continue;
        }
        tried += 1;
        let mut around = Surroundings::new(&told, &Caution::default());
        scan.take(&world, &pose, told.lidar.range_max_m);
        scan.write_distances_m(&mut ranges_m);
        // The data sheet's noise, and two beams in a hundred without an echo.
        for range_m in &mut ranges_m {
            let noisy = *range_m + told.lidar.range_std_m.unwrap() * random.normal();
            let lost = random.uniform() < 0.02;
            *range_m = if lost { told.lidar.range_max_m } else { noisy.max(0.0) };
        }
        around.tick(EncoderCounts::default(), Some(&ranges_m));
        let wanted = Twist {
            v_m_s: 1.6 * random.uniform() - 0.8,
            omega_rad_s: 8.0 * random.uniform() - 4.0,
        };
        let given = around.limit(wanted);
        let tau = Vector3::new(given.v_m_s, 0.0, given.omega_rad_s) * around.horizon_s;
        let end = pose.boxplus(&tau);
        let touches = world.blocks(&pose, &end, told.robot.body_radius_m);
        assert!(!touches, "{wanted:?} as {given:?} from {pose:?}");
        limited += u32::from(given != told.robot.drive.limit(wanted, 20.0));
        stopped += u32::from(given.v_m_s == 0.0);
    }
    assert!(limited > 200 && stopped > 50, "{limited} {stopped}");
}

#[test]
fn what_nothing_is_known_of_is_not_driven_into() {
    let told = start(&apartment(), SE2::new(6.0, 4.5, 0.0));
    let mut around = Surroundings::new(&told, &Caution::default());
    let ahead = Twist { v_m_s: 0.3, omega_rad_s: 0.5 };
    let turn = Twist { v_m_s: 0.0, omega_rad_s: 1.0 };
    around.tick(EncoderCounts::default(), None);
    assert_eq!((around.limit(ahead), around.limit(turn)), (Twist::default(), turn));
    // A scan of an empty plain, and then none for half a second.
    around.tick(EncoderCounts::default(), Some(&[8.0; 180]));
    assert_eq!(around.limit(ahead), ahead);
    (0..25).for_each(|_| around.tick(EncoderCounts::default(), None));
    assert_eq!(around.limit(ahead), Twist::default());
    let nan = Twist { v_m_s: f64::NAN, omega_rad_s: 1.0 };
    assert_eq!(around.limit(nan), Twist::default());
}

#[test]
fn one_scan_without_echoes_takes_nothing_away() {
    let told = start(&apartment(), SE2::new(6.0, 4.5, 0.0));
    let mut around = Surroundings::new(&told, &Caution::default());
    let ahead = Twist { v_m_s: 0.5, omega_rad_s: 0.0 };
    around.tick(EncoderCounts::default(), Some(&[0.25; 180]));
    let clear_m = around.clear_m(ahead);
    assert!(clear_m > 0.07 && clear_m < 0.09, "{clear_m}");
    around.tick(EncoderCounts::default(), Some(&[8.0; 180]));
    assert_eq!(around.clear_m(ahead), clear_m);
    // It comes nearer by what the wheels turn: one count of 4096, 50 µm.
    around.tick(EncoderCounts { left: 100, right: 100 }, None);
    let nearer_m = clear_m - around.clear_m(ahead);
    assert!((nearer_m - 100.0 * 0.033 * std::f64::consts::TAU / 4096.0).abs() < 1e-9);
    // And is forgotten in time.
    (0..120).for_each(|_| around.tick(EncoderCounts::default(), Some(&[8.0; 180])));
    assert_eq!(around.clear_m(ahead), REACH_M);
}
