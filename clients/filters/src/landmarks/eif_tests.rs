//! The information filter: the same answers as the Kalman filter, and sums in any order.

use nalgebra::Matrix3;

use super::*;
use crate::ekf_landmarks;
use crate::ekf_landmarks::EkfLandmarks;
use crate::landmarks::test_robot::{Robot, first_pose, follow, ring, start};

fn both() -> (EkfLandmarks, EifLandmarks) {
    let told = start(&ring());
    let ekf = EkfLandmarks::new(&told, &ekf_landmarks::Options::default()).unwrap();
    (ekf, EifLandmarks::new(&told, &Options::default()).unwrap())
}

fn off(ekf: &EkfLandmarks, eif: &EifLandmarks) -> [f64; 2] {
    let ((a, of_a), (b, of_b)) = (ekf.pose(), eif.pose());
    [a.boxminus(&b).norm(), (of_a - of_b).norm() / of_a.norm()]
}

#[test]
fn with_one_reading_in_a_tick_it_answers_as_the_kalman_filter_does() {
    for has_ids in [true, false] {
        let (mut ekf, mut eif) = both();
        let mut robot = Robot::new(&ring(), has_ids, 5);
        let mut used = 0;
        for tick in 0..500 {
            let counts = robot.drive();
            ekf.advance(counts);
            eif.advance(counts);
            let seen = robot.look();
            let one = &seen[..seen.len().min(usize::from(tick % 5 == 0))];
            let innovations = [ekf.see(one), eif.see(one)];
            if let [Some(a), Some(b)] = innovations {
                assert!((a.nis - b.nis).abs() < 1e-6 * (1.0 + a.nis), "{tick}: {a:?} {b:?}");
                assert_eq!(a.degrees, b.degrees);
                used += 1;
            } else {
                assert_eq!(innovations, [None; 2], "{tick}");
            }
            let [pose, covariance] = off(&ekf, &eif);
            assert!(pose < 1e-8 && covariance < 1e-6, "{tick}: {pose} {covariance}");
        }
        assert!(used > 50, "{used}");
    }
}

#[test]
fn readings_add_up_in_any_order() {
    let (_, mut first) = both();
    let mut robot = Robot::new(&ring(), true, 3);
    first.advance(robot.drive());
    let mut second = first.clone();
    let mut seen = robot.look();
    assert!(seen.len() > 2, "{seen:?}");
    let told = first.see(&seen).unwrap();
    seen.reverse();
    let reversed = second.see(&seen).unwrap();
    assert!((told.nis - reversed.nis).abs() < 1e-9 && told.degrees == reversed.degrees);
    let ((a, of_a), (b, of_b)) = (first.pose(), second.pose());
    assert!(a.boxminus(&b).norm() < 1e-12 && (of_a - of_b).norm() < 1e-15, "{a:?} {b:?}");
}

#[test]
fn it_is_as_exact_as_it_says() {
    let (mut sum, runs) = (0.0, 20);
    for seed in 0..runs {
        let (_, mut eif) = both();
        let (rms_m, nees) = follow(&mut eif, &mut Robot::new(&ring(), true, seed), 300);
        assert!(rms_m < 0.06, "{seed}: {rms_m} m");
        sum += nees;
    }
    let mean = sum / runs as f64;
    assert!((1.5..5.0).contains(&mean), "{mean}");
}

#[test]
fn an_update_worked_by_hand() {
    let mut told = start(&[rusty_geometry::Landmark { id: 1, at: [2.0, 0.0] }]);
    told.initial_pose = Some(SE2::identity());
    let mut eif = EifLandmarks::new(&told, &Options::default()).unwrap();
    eif.information = Matrix3::from_diagonal(&Vector3::new(100.0, 100.0, 25.0));
    let nis = eif.see(&[LandmarkReading::new(Some(1), 2.1, 0.0)]).unwrap();
    // 2 m ahead is measured as 2.1 m: 1/0.0025 is added to 100, and the pose goes back by
    // 0.1 · 400/500.
    let (pose, covariance) = eif.pose();
    assert!((pose.x() + 0.08).abs() < 1e-9 && pose.y().abs() < 1e-12, "{pose:?}");
    assert!((nis.nis - 0.01 / 0.0125).abs() < 1e-9 && nis.degrees == 2, "{nis:?}");
    assert!((eif.information[(0, 0)] - 500.0).abs() < 1e-9, "{}", eif.information);
    // The bearing has H = (0, −1/2, −1): what the Kalman filter has after it.
    let s = 0.0025 + 0.04 + 0.035 * 0.035;
    assert!((covariance[(2, 2)] - (0.04 - 0.04 * 0.04 / s)).abs() < 1e-9, "{covariance}");
    // A landmark that the map does not have is not used.
    assert_eq!(eif.see(&[LandmarkReading::new(Some(2), 2.1, 0.0)]), None);
    assert_eq!(eif.pose().0, pose);
}

#[test]
fn it_begins_at_the_initial_pose_and_says_what_it_needs() {
    let (_, eif) = both();
    assert_eq!(eif.pose().0, first_pose());
    let told = Start { initial_pose: None, ..start(&ring()) };
    let refused = EifLandmarks::new(&told, &Options::default()).unwrap_err().to_string();
    assert!(refused.contains("initial_pose"), "{refused}");
}
