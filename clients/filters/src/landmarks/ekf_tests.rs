//! EKF localisation by landmarks: an update worked by hand, and errors as large as it says.

use nalgebra::Vector3;
use rusty_metrics::chi_square::quantile;

use super::*;
use crate::landmarks::test_robot::{Robot, first_pose, follow, ring, start};

#[test]
fn an_update_worked_by_hand() {
    let mut told = start(&[rusty_geometry::Landmark { id: 1, at: [2.0, 0.0] }]);
    told.initial_pose = Some(SE2::identity());
    let start_options = StartOptions { start_std_m: 0.1, start_std_deg: 0.2_f64.to_degrees() };
    let options = Options { start: start_options, ..Options::default() };
    let mut ekf = EkfLandmarks::new(&told, &options).unwrap();
    // 2 m ahead is measured as 2.1 m: the robot is behind by 0.01 / (0.01 + 0.0025) of it.
    let nis = ekf.see(&[LandmarkReading::new(Some(1), 2.1, 0.0)]).unwrap();
    let (pose, covariance) = ekf.pose();
    assert!((pose.x() + 0.08).abs() < 1e-9 && pose.y().abs() < 1e-12, "{pose:?}");
    assert!((nis.nis - 0.01 / 0.0125).abs() < 1e-9 && nis.degrees == 2, "{nis:?}");
    // P R / (P + R) along; the bearing has H = (0, −1/2, −1), S = 0.0025 + 0.04 + R.
    assert!((covariance[(0, 0)] - 0.01 * 0.0025 / 0.0125).abs() < 1e-9, "{covariance}");
    let s = 0.0025 + 0.04 + 0.035 * 0.035;
    assert!((covariance[(2, 2)] - (0.04 - 0.04 * 0.04 / s)).abs() < 1e-9, "{covariance}");
    // A landmark that the map does not have is not used.
    assert_eq!(ekf.see(&[LandmarkReading::new(Some(2), 2.1, 0.0)]), None);
    assert_eq!(ekf.pose(), (pose, covariance));
}

#[test]
fn errors_are_as_large_as_it_says_with_identities_and_without() {
    for has_ids in [true, false] {
        let (runs, mut nees) = (30_u32, 0.0);
        for seed in 0..u64::from(runs) {
            let mut ekf = EkfLandmarks::new(&start(&ring()), &Options::default()).unwrap();
            let mut robot = Robot::new(&ring(), has_ids, seed);
            let wrong = Vector3::new(0.02, -0.02, 0.02);
            ekf.pose_in_world = robot.pose.boxplus(&wrong);
            let (rms_m, _) = follow(&mut ekf, &mut robot, 300);
            assert!(rms_m < 0.06, "{seed}: {rms_m} m");
            let (pose, covariance) = ekf.pose();
            let tau = robot.pose.boxminus(&pose);
            nees += tau.dot(&(covariance.try_inverse().unwrap() * tau));
        }
        let degrees = 3.0 * f64::from(runs);
        let (low, high) = (quantile(0.005, degrees), quantile(0.995, degrees));
        assert!(low < nees && nees < high, "ids {has_ids}: {low} < {nees} < {high}");
    }
}

#[test]
fn a_reading_between_two_landmarks_is_not_used() {
    let pair = [[2.0, 0.2], [2.0, -0.2]].map(|at| rusty_geometry::Landmark { id: 1, at });
    let pair = [pair[0], rusty_geometry::Landmark { id: 2, ..pair[1] }];
    let mut told = start(&pair);
    told.initial_pose = Some(SE2::identity());
    let mut ekf = EkfLandmarks::new(&told, &Options::default()).unwrap();
    let (before, between) = (ekf.pose(), LandmarkReading::new(None, 2.01, 0.0));
    assert_eq!(ekf.see(&[between]), None);
    assert_eq!(ekf.pose(), before);
    // Both together are not ambiguous.
    let both = [0.1, -0.1].map(|bearing_rad| LandmarkReading::new(None, 2.01, bearing_rad));
    assert_eq!(ekf.see(&both).unwrap().degrees, 4);
}

#[test]
fn without_a_map_or_a_start_it_says_what_to_do() {
    let refused = |change: fn(&mut Start)| {
        let mut told = start(&ring());
        change(&mut told);
        EkfLandmarks::new(&told, &Options::default()).unwrap_err().to_string()
    };
    assert!(refused(|told| told.map = None).contains("map = \"given\""));
    assert!(refused(|told| told.map.as_mut().unwrap().landmarks.clear()).contains("landmarks"));
    assert!(refused(|told| told.initial_pose = None).contains("initial_pose"));
    assert!(refused(|told| told.sensors.landmarks = None).contains("sensors.landmarks"));
    let begun = EkfLandmarks::new(&start(&ring()), &Options::default()).unwrap();
    assert_eq!(begun.pose().0, first_pose());
}
