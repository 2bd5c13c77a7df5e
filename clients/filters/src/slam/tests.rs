//! Round trips: loops are closed, and only where there are any.

use rusty_geometry::{SE2, Twist, apartment};

use super::*;
use crate::scan_match::tests::{Robot, corridor, start};

/// Drives `legs` (speed m/s, rad/s, ticks), with a scan every fifth tick.
fn drive(robot: &mut Robot, filter: &mut Slam, legs: &[(f64, f64, usize)]) {
    for &(v_m_s, omega_rad_s, ticks) in legs {
        for k in 0..ticks {
            filter.advance(robot.drive(Twist { v_m_s, omega_rad_s }));
            if k % 5 == 4 {
                filter.scan(&robot.look());
            }
        }
    }
}

fn filter(robot: &Robot, options: &SlamOptions) -> Slam {
    Slam::new(&start(&robot.lidar, Some(robot.pose)), options)
}

/// Two rounds through the largest room.
const ROUNDS: &[(f64, f64, usize)] = &[(0.5, 0.6, 1100)];

#[test]
fn loops_hold_the_map_together() {
    let here = SE2::new(10.4, 3.0, 1.57);
    let mut robot = Robot::new(apartment(), here, 21);
    let mut slam = filter(&robot, &SlamOptions::default());
    drive(&mut robot, &mut slam, ROUNDS);
    assert!(slam.loops() >= 5, "{}", slam.loops());
    let (pose, covariance) = slam.pose();
    let error = robot.pose.boxminus(&pose);
    assert!(error.norm() < 0.03, "{error}");
    let nees = (error.transpose() * covariance.try_inverse().unwrap() * error).x;
    // Once in ten thousand runs of a right filter.
    assert!(nees < 21.1, "{nees}");
    let world = apartment();
    let points: Vec<_> = slam.map().flat_map(|(_, points)| points).collect();
    let mean = points.iter().map(|p| world.distance_to_nearest(*p)).sum::<f64>();
    assert!(mean / (points.len() as f64) < 0.03, "{} points", points.len());
    // Without loops it is the same filter, less sure of itself.
    let mut robot = Robot::new(apartment(), here, 21);
    let closing = LoopOptions { loops: 0, ..LoopOptions::default() };
    let mut open = filter(&robot, &SlamOptions { closing, ..SlamOptions::default() });
    drive(&mut robot, &mut open, ROUNDS);
    assert_eq!(open.loops(), 0);
    assert!(open.pose().1.determinant() > 2.0 * covariance.determinant());
}

#[test]
fn a_corridor_closes_no_loop_with_another_place_in_it() {
    // Along a corridor that looks the same everywhere: matches along it say
    // nothing, and the way stays what the wheels say.
    let mut robot = Robot::new(corridor(), SE2::new(-8.0, 0.0, 0.0), 5);
    let mut slam = filter(&robot, &SlamOptions::default());
    drive(&mut robot, &mut slam, &[(0.5, 0.0, 1200)]);
    let error = robot.pose.boxminus(&slam.pose().0);
    assert!(error.x.abs() < 0.15 && error.y.abs() < 0.05 && error.z.abs() < 0.02, "{error}");
}

#[test]
fn nothing_seen_is_no_map() {
    let mut robot = Robot::new(apartment(), SE2::new(1.0, 2.0, 0.0), 6);
    let mut slam = filter(&robot, &SlamOptions::default());
    for _ in 0..50 {
        slam.advance(robot.drive(Twist { v_m_s: 0.3, omega_rad_s: 0.1 }));
        slam.scan(&[8.0; 180]);
    }
    assert_eq!((slam.map().count(), slam.loops()), (0, 0));
    let before = slam.pose();
    assert!(before.0.boxminus(&robot.pose).norm() < 0.1 && before.1[(0, 0)] > 0.0);
    // The first scan that shows something is the first pose of the map, as unsure
    // as the way to it.
    slam.scan(&robot.look());
    assert_eq!(slam.map().count(), 1);
    assert_eq!(slam.pose(), before);
}

#[test]
fn the_command_line_has_every_option_once() {
    #[derive(clap::Parser)]
    struct Cli {
        #[command(flatten)]
        _args: rusty_clients::ClientArgs,
        #[command(flatten)]
        options: SlamOptions,
    }
    <Cli as clap::CommandFactory>::command().debug_assert();
    let cli = <Cli as clap::Parser>::parse_from(["slam", "--log", "run.log"]);
    assert_eq!(cli.options, SlamOptions::default());
}
