//! Round trips: loops are closed, and only where there are any.

use rusty_geometry::{SE2, Twist, apartment};

use super::*;
use crate::moment::Moment;
use crate::scan_match::tests::{Robot, corridor, start};

/// Drives `legs` (speed m/s, rad/s, ticks), with a scan every fifth tick.
pub(super) fn drive(robot: &mut Robot, filter: &mut Slam, legs: &[(f64, f64, usize)]) {
    for &(v_m_s, omega_rad_s, ticks) in legs {
        for k in 0..ticks {
            filter.advance(robot.drive(Twist { v_m_s, omega_rad_s }));
            if k % 5 == 4 {
                filter.scan(&robot.look());
            }
        }
    }
}

pub(super) fn filter(robot: &Robot, options: &SlamOptions) -> Slam {
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
fn what_is_believed_of_the_start_moves_no_pose_and_is_in_the_answer() {
    let here = SE2::new(10.4, 3.0, 1.57);
    let after = |start_std_m: f64, start_std_deg: f64| {
        let mut robot = Robot::new(apartment(), here, 21);
        let front = ScanMatchOptions { start_std_m, start_std_deg, ..Default::default() };
        let mut slam = filter(&robot, &SlamOptions { front, ..SlamOptions::default() });
        drive(&mut robot, &mut slam, ROUNDS);
        assert!(slam.loops() >= 5, "{}", slam.loops());
        slam.pose()
    };
    let ((certain, least), (pose, covariance)) = (after(0.0, 0.0), after(0.4, 3.0));
    assert_eq!(pose, certain);
    let start = crate::tangent::independent(0.4, 3.0f64.to_radians());
    let expected = carried(&start, &(here.inverse() * pose));
    assert!((covariance - least - expected).norm() < 1e-9, "{covariance}");
}

#[test]
fn loops_in_a_corridor_do_not_move_the_robot_along_it() {
    // It looks the same everywhere: matches along it say nothing, be it with other
    // places in it or with the same one, and the way stays what the wheels say.
    let everywhere = LoopOptions { loop_distance_m: 20.0, loop_share: 0.1, ..Default::default() };
    let onwards = vec![(0.5, 0.0, 1200)];
    let and_back = vec![(0.5, 0.0, 600), (-0.5, 0.0, 600)];
    for (closing, legs) in [(everywhere, onwards), (LoopOptions::default(), and_back)] {
        let mut robot = Robot::new(corridor(), SE2::new(-8.0, 0.0, 0.0), 5);
        let options = SlamOptions { closing, ..SlamOptions::default() };
        let mut slam = filter(&robot, &options);
        drive(&mut robot, &mut slam, &legs);
        assert!(slam.loops() >= 3, "{} loops", slam.loops());
        let (pose, covariance) = slam.pose();
        let error = robot.pose.boxminus(&pose);
        assert!(error.x.abs() < 0.15 && error.y.abs() < 0.05 && error.z.abs() < 0.02, "{error}");
        assert!(error.x.abs() < 3.0 * covariance[(0, 0)].sqrt(), "{error}, {covariance}");
    }
}

/// A filter that saves its map to `map` in this folder and has seen one scan.
fn that_saves(folder: &Path, until: Option<Moment>) -> (Robot, Slam) {
    let mut robot = Robot::new(apartment(), SE2::new(1.0, 2.0, 0.0), 6);
    let save_map = Some(folder.join("map"));
    let mut slam = filter(&robot, &SlamOptions { save_map, until, ..SlamOptions::default() });
    assert!(slam.takes_in(100.02));
    slam.scan(&robot.look());
    (robot, slam)
}

#[test]
fn a_map_of_nothing_is_named_and_a_run_that_never_began_is_silent() {
    let folder = tempfile::tempdir().unwrap();
    let robot = Robot::new(apartment(), SE2::new(1.0, 2.0, 0.0), 6);
    let save_map = Some(folder.path().join("map"));
    let blind =
        || filter(&robot, &SlamOptions { save_map: save_map.clone(), ..Default::default() });
    blind().finish().unwrap();
    let mut slam = blind();
    assert!(slam.takes_in(100.02));
    slam.scan(&[8.0; 180]);
    let error = slam.finish().unwrap_err().to_string();
    assert_eq!(error, "--save-map: no scan showed walls, no map written");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_key_scan_that_does_not_fit_is_named_and_those_before_it_are_the_map() {
    let folder = tempfile::tempdir().unwrap();
    let (_, mut slam) = that_saves(folder.path(), None);
    slam.graph.extend(&SE2::new(1e9, 0.0, 0.0), &Matrix3::identity());
    slam.graph.extend(&SE2::identity(), &Matrix3::identity());
    (0..2).for_each(|_| slam.seen.push(slam.seen[0].clone()));
    let error = slam.finish().unwrap_err().to_string();
    assert!(error.starts_with("--save-map: key scan 2 of 3: with a scan taken at"), "{error}");
    for ending in ["pgm", "yaml", "png"] {
        assert!(folder.path().join("map").with_extension(ending).exists(), "{ending}");
    }
}

#[test]
fn later_scans_are_left_out_and_the_wheels_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let (mut robot, mut slam) = that_saves(folder.path(), Some(Moment::Seconds(2.0)));
    let mut last = 0;
    for k in 1..300 {
        slam.advance(robot.drive(Twist { v_m_s: 0.3, omega_rad_s: 0.1 }));
        if slam.takes_in(100.02 + 0.02 * f64::from(k)) && k % 5 == 0 {
            slam.scan(&robot.look());
            last = k;
        }
    }
    // The run began at 100 s: the scan after 1.92 s is the last.
    assert_eq!(last, 95);
    let (pose, _) = slam.pose();
    assert!(pose.boxminus(&robot.pose).norm() < 0.1, "{pose:?} for {:?}", robot.pose);
    let keys = slam.map().count();
    assert!((1..=2).contains(&keys), "{keys}");
    slam.finish().unwrap();
    assert!(folder.path().join("map.yaml").exists());
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
    for option in ["--loop-share", "--key-share"] {
        for value in ["nan", "-1", "40"] {
            let args = ["slam".to_owned(), format!("{option}={value}")];
            let refused = <Cli as clap::Parser>::try_parse_from(args).err().unwrap().to_string();
            assert!(refused.contains("give a share from 0 to 1"), "{refused}");
        }
    }
}
