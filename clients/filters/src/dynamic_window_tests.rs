//! Single decisions, and whole ways without noise.

use super::*;
use crate::Random;
use crate::pursuit::Pursuit;
use crate::surroundings::tests::{ranges_from, seen_from, start};
use rusty_geometry::{EncoderCounts, apartment};

/// An aim so far ahead and to the left, with a long way left.
fn aim_at(x_m: f64, y_m: f64) -> Aim {
    Aim { in_body: Point2::new(x_m, y_m), off_m: 0.0, left_m: 5.0 }
}

fn rolling(v_m_s: f64) -> DynamicWindow {
    let decided = Twist { v_m_s, omega_rad_s: 0.0 };
    DynamicWindow { decided, since_s: 0.1 - 0.02, ..DynamicWindow::new(Acceleration::default()) }
}

#[test]
fn a_decision_is_within_the_window_and_can_be_stopped() {
    let mut random = Random::new(5, 1);
    let (caution, most) = (Caution::default(), Acceleration::default());
    let mut braked = 0;
    for _ in 0..300 {
        let between = |random: &mut Random, a: f64, b: f64| a + (b - a) * random.uniform();
        let x_m = between(&mut random, 0.4, 11.6);
        let theta_rad = between(&mut random, -3.1, 3.1);
        let y_m = between(&mut random, 3.9, 5.1);
        let around = seen_from(SE2::new(x_m, y_m, theta_rad));
        let before_m_s = between(&mut random, 0.0, 0.5);
        let aim = aim_at(between(&mut random, -0.3, 0.3), between(&mut random, -0.3, 0.3));
        let command = rolling(before_m_s).command(&around, &aim, &caution, 0.02);
        assert!((0.0..=caution.speed_m_s).contains(&command.v_m_s), "{command:?}");
        assert!(command.omega_rad_s.abs() <= most.turn_accel_rad_s2 * 0.1 + 1e-12);
        assert!(command.v_m_s <= before_m_s + most.accel_m_s2 * 0.1 + 1e-12, "{command:?}");
        if command.v_m_s > 0.0 {
            let stop_m = command.v_m_s * command.v_m_s / (2.0 * most.accel_m_s2);
            assert!(stop_m <= around.clear_m(command) + 1e-12, "{command:?} from {x_m}, {y_m}");
        }
        braked += u32::from(command.v_m_s < before_m_s - most.accel_m_s2 * 0.1 - 1e-9);
    }
    assert!(braked > 5, "no robot was stopped before a wall: {braked}");
}

#[test]
fn it_turns_to_its_aim_and_drives_to_what_is_ahead() {
    let around = seen_from(SE2::new(9.6, 4.5, 0.0));
    let decide =
        |x_m, y_m| rolling(0.3).command(&around, &aim_at(x_m, y_m), &Caution::default(), 0.02);
    assert_eq!(decide(0.35, 0.0), Twist { v_m_s: 0.35, omega_rad_s: 0.0 });
    assert!((decide(0.0, 0.3).omega_rad_s - 0.3).abs() < 1e-12);
    assert!((decide(0.0, -0.3).omega_rad_s + 0.3).abs() < 1e-12);
}

#[test]
fn without_a_new_scan_the_decision_stays() {
    let mut around = seen_from(SE2::new(4.0, 4.5, 0.0));
    let mut window = rolling(0.3);
    let first = window.command(&around, &aim_at(0.35, 0.0), &Caution::default(), 0.02);
    around.tick(EncoderCounts::default(), None);
    assert_eq!(window.command(&around, &aim_at(0.0, 0.3), &Caution::default(), 0.02), first);
}

/// Drives a way without noise, and returns the least distance from a wall and the end.
fn drive(corners: &[(f64, f64)], mut pose: SE2) -> (f64, SE2) {
    let (world, caution) = (apartment(), Caution::default());
    let told = start(&world, pose);
    let drive = told.robot.drive;
    let mut around = Surroundings::new(&told, &caution);
    let mut way = Pursuit::new(corners.iter().map(|(x, y)| Point2::new(*x, *y)).collect());
    let mut window = DynamicWindow::new(Acceleration::default());
    let (mut wheels, mut least_m) = ([0.0; 2], f64::INFINITY);
    for tick in 0..6000 {
        let counts =
            wheels.map(|rad: f64| rad * drive.ticks_per_rev as f64 / std::f64::consts::TAU);
        let counts = EncoderCounts { left: counts[0] as i64, right: counts[1] as i64 };
        let ranges_m = (tick % 5 == 0).then(|| ranges_from(&told, &pose));
        around.tick(counts, ranges_m.as_deref());
        let aim = way.aim(&pose).unwrap();
        if aim.left_m + aim.off_m < 0.15 {
            return (least_m, pose);
        }
        let twist = window.command(&around, &aim, &caution, told.dt_s);
        let rates = drive.wheel_rates(twist);
        wheels[0] += rates.left_rad_s * told.dt_s;
        wheels[1] += rates.right_rad_s * told.dt_s;
        pose = pose.boxplus(&(Vector3::new(twist.v_m_s, 0.0, twist.omega_rad_s) * told.dt_s));
        least_m = least_m.min(world.distance_to_nearest(Point2::from(pose.translation())));
    }
    panic!("it never came to the end: {pose:?}");
}

#[test]
fn it_comes_through_a_door_and_back_without_touching() {
    let radius_m = start(&apartment(), SE2::identity()).robot.body_radius_m;
    let there = [(4.0, 4.5), (6.5, 4.5), (6.5, 5.6), (5.4, 7.0)];
    let back = [(5.4, 7.0), (6.5, 5.6), (6.5, 4.5), (4.0, 4.5)];
    for (way, from) in [(there, SE2::new(4.0, 4.5, 2.0)), (back, SE2::new(5.4, 7.0, 3.0))] {
        let (least_m, end) = drive(&way, from);
        assert!(least_m > radius_m, "{least_m} m from a wall");
        let last = way[way.len() - 1];
        assert!((Point2::from(end.translation()) - Point2::new(last.0, last.1)).norm() < 0.16);
    }
}
