//! Searches for the place where a robot is that the graph has elsewhere.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix3, Vector3};
use rusty_geometry::{SE2, Twist, World, apartment};

use super::super::tests::{drive, filter};
use super::super::{Seen, Slam, SlamOptions};
use crate::beams::believed_lidar;
use crate::icp::{Laser, Surface};
use crate::scan_match::tests::{Robot, corridor, world_of};

/// A filter after a round through the largest room.
fn after_a_round(seed: u64) -> (Robot, Slam) {
    let mut robot = Robot::new(apartment(), SE2::new(10.4, 3.0, 1.57), seed);
    let mut slam = filter(&robot, &SlamOptions::default());
    drive(&mut robot, &mut slam, &[(0.5, 0.6, 550)]);
    (robot, slam)
}

/// A robot at the origin whose laser sees nothing behind.
fn looking_ahead(world: World, seed: u64) -> Robot {
    let mut robot = Robot::new(world, SE2::identity(), seed);
    (robot.lidar.first_bearing_rad, robot.lidar.fov_rad) = (-FRAC_PI_2, PI);
    robot
}

/// Moves the robot by `motion` and adds a key scan there. The wheels are off by `error`
/// and as unsure as that.
fn add_key(robot: &mut Robot, slam: &mut Slam, motion: SE2, error: SE2) {
    let std = error.log().abs() + Vector3::new(0.02, 0.02, 0.01);
    add_sure_key(robot, slam, motion, error, std);
}

/// The same, with wheels that have these deviations.
fn add_sure_key(robot: &mut Robot, slam: &mut Slam, motion: SE2, error: SE2, std: Vector3<f64>) {
    robot.pose = robot.pose * motion;
    let ranges_m = robot.look();
    let laser = Laser::new(&believed_lidar(&slam.start));
    let surface = Surface::new(&laser, &laser.rays(&ranges_m), 0.005);
    slam.seen.push(Seen { time_s: 0.0, ranges_m, surface });
    let covariance = Matrix3::from_diagonal(&std.component_mul(&std));
    slam.covariance += covariance;
    slam.graph.extend(&(motion * error), &covariance.try_inverse().unwrap());
}

#[test]
fn two_loops_bring_a_lost_robot_back_and_one_does_not() {
    for (seed, error) in [
        (1, SE2::new(1.4, -0.9, 0.4)),
        (2, SE2::new(-1.2, 1.0, -0.3)),
        (3, SE2::new(0.8, 1.5, 0.45)),
    ] {
        let (mut robot, mut slam) = after_a_round(seed);
        let before = slam.loops();
        let here = robot.pose;
        add_key(&mut robot, &mut slam, SE2::identity(), error);
        assert!(!slam.close_loops() && slam.loops() == before, "{seed}: alone it counts");
        let waiting = slam.unconfirmed.clone();
        assert!(!waiting.is_empty(), "{seed}");
        for found in waiting {
            let off = here.boxminus(&(slam.graph.poses()[found.from] * found.motion));
            assert!(off.norm() < 0.1, "{seed}: {off}");
        }
        // The next key scan, by wheels that are as sure as usual.
        add_key(&mut robot, &mut slam, SE2::new(0.6, 0.0, 0.3), SE2::identity());
        let next = robot.pose;
        assert!(slam.close_loops() && slam.loops() >= before + 2, "{seed}: {}", slam.loops());
        slam.graph.optimise().unwrap();
        let [.., at_here, at_next] = slam.graph.poses() else { unreachable!() };
        for (pose, truth) in [(at_here, here), (at_next, next)] {
            assert!(truth.boxminus(pose).norm() < 0.1, "{seed}: {pose:?} for {truth:?}");
        }
    }
}

#[test]
fn a_graph_that_is_too_sure_finds_the_place() {
    let mut found = 0;
    for seed in 1..=8 {
        for error in [SE2::new(1.0, 0.0, 0.0), SE2::new(0.0, -1.0, 0.0)] {
            let (mut robot, mut slam) = after_a_round(seed);
            let std = Vector3::new(0.25, 0.25, 0.02);
            add_sure_key(&mut robot, &mut slam, SE2::identity(), error, std);
            slam.close_loops();
            for loop_ in &slam.unconfirmed {
                let off = robot.pose.boxminus(&(slam.graph.poses()[loop_.from] * loop_.motion));
                assert!(off.norm() < 0.1, "{seed}: {off}");
                found += 1;
            }
        }
    }
    assert!(found >= 10, "{found}");
}

#[test]
fn a_place_that_fits_twice_is_no_loop() {
    let mut robot = Robot::new(corridor(), SE2::new(-8.0, 0.0, 0.0), 4);
    let mut slam = filter(&robot, &SlamOptions::default());
    drive(&mut robot, &mut slam, &[(0.5, 0.0, 600)]);
    let before = slam.loops();
    let back = SE2::new(-4.0, 0.0, 0.0);
    for (motion, error) in
        [(back, SE2::new(1.5, 0.0, 0.0)), (SE2::new(0.8, 0.0, 0.0), SE2::identity())]
    {
        add_key(&mut robot, &mut slam, motion, error);
        assert!(!slam.close_loops(), "{motion:?}");
    }
    assert_eq!((slam.loops(), slam.unconfirmed.len()), (before, 0));
}

/// Down one of two corridors that meet, from the corner, and back to it through the other one:
/// its wall on the left is that on the right seen from behind.
#[test]
fn a_wall_seen_from_behind_is_no_loop() {
    let walls = [
        [-1.25, -1.25, 40.0, -1.25],
        [-1.25, -1.25, -1.25, 40.0],
        [1.25, 1.25, 40.0, 1.25],
        [1.25, 1.25, 1.25, 40.0],
    ];
    for seed in 1..=4 {
        let world = world_of([-2.0, -2.0, 40.0, 40.0], &walls);
        let mut robot = looking_ahead(world, seed);
        let mut slam = filter(&robot, &SlamOptions::default());
        drive(&mut robot, &mut slam, &[(0.5, 0.0, 1500)]);
        let (before, std) = (slam.loops(), Vector3::new(2.0, 2.0, 0.03));
        for away_m in [5.5, 4.6, 3.7] {
            let here = SE2::new(0.0, away_m, -FRAC_PI_2);
            let motion = robot.pose.inverse() * here;
            add_sure_key(&mut robot, &mut slam, motion, SE2::new(0.5, 0.1, 0.0), std);
            assert!(!slam.close_loops(), "{seed}: {away_m}");
            for found in &slam.unconfirmed {
                let off = here.boxminus(&(slam.graph.poses()[found.from] * found.motion));
                assert!(off.norm() < 0.1, "{seed}, {away_m}: {off}");
            }
        }
        assert_eq!(slam.loops(), before, "{seed}");
    }
}

/// A corridor with niches of half a metre on both sides.
fn corridor_with_niches() -> World {
    let mut walls = Vec::new();
    for (side, first_m) in [(1.0, 0.0), (-1.0, 1.7)] {
        let mut from = -2.0;
        for niche in [3.0, 8.5, 14.0, 21.5, 27.0, 34.0] {
            let (at, end) = (niche + first_m, niche + first_m + 1.0);
            walls.push([from, side, at, side]);
            walls.push([at, side, at, 1.5 * side]);
            walls.push([at, 1.5 * side, end, 1.5 * side]);
            walls.push([end, 1.5 * side, end, side]);
            from = end;
        }
        walls.push([from, side, 60.0, side]);
    }
    world_of([-2.0, -2.0, 60.0, 2.0], &walls)
}

/// Down a corridor, and back in it by wheels that are unsure of the distance.
#[test]
fn a_match_that_slides_along_a_corridor_is_no_loop() {
    let mut found = 0;
    for seed in 1..=8 {
        let mut robot = looking_ahead(corridor_with_niches(), seed);
        robot.lidar.range_max_m = 30.0;
        let mut slam = filter(&robot, &SlamOptions::default());
        for k in 0..2500 {
            slam.advance(robot.drive(Twist { v_m_s: 0.5, omega_rad_s: 0.0 }));
            robot.pose = SE2::new(robot.pose.x(), 0.0, 0.0);
            if k % 5 == 4 {
                slam.scan(&robot.look());
            }
        }
        for x_m in [2.0, 5.0, 7.0, 9.5, 12.0, 14.0, 16.0, 18.0] {
            let here = SE2::new(x_m, 0.1, 0.05);
            let motion = robot.pose.inverse() * here;
            let std = Vector3::new(0.3, 0.05, 0.02);
            add_sure_key(&mut robot, &mut slam, motion, SE2::new(0.3, 0.0, 0.0), std);
            slam.close_loops();
            for new in slam.unconfirmed.drain(..) {
                let off = here.boxminus(&(slam.graph.poses()[new.from] * new.motion));
                assert!(off.norm() < 0.25, "{seed}, {x_m}: {off}");
                found += 1;
            }
        }
    }
    assert!(found >= 40, "{found}");
}

#[test]
fn loops_that_contradict_each_other_are_not_added() {
    let (mut robot, mut slam) = after_a_round(5);
    add_key(&mut robot, &mut slam, SE2::identity(), SE2::new(1.4, -0.9, 0.4));
    slam.close_loops();
    let before = slam.loops();
    assert!(!slam.unconfirmed.is_empty());
    for found in &mut slam.unconfirmed {
        found.motion = found.motion * SE2::new(0.5, 0.5, 0.0);
    }
    add_key(&mut robot, &mut slam, SE2::new(0.6, 0.0, 0.3), SE2::identity());
    assert!(!slam.close_loops());
    assert_eq!(slam.loops(), before);
}
