//! The model against finite differences and numbers worked by hand, and the association.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix3x2, Vector3};
use rusty_contract::DataSheet;
use rusty_contract::data_sheet::LandmarkSensorSheet;

use super::*;
use crate::landmarks::test_robot::{ring, start};

fn expected(pose: &SE2, at: [f64; 2]) -> Expected {
    LandmarkModel::expected(pose, &Vector2::from(at)).unwrap()
}

fn model() -> LandmarkModel {
    LandmarkModel::new(0.05, 0.035, &LandmarkOptions::default())
}

#[test]
fn readings_worked_by_hand() {
    // At (1, 2) and facing north: 3 m ahead, 1 m to the left, behind to the right.
    let pose = SE2::new(1.0, 2.0, FRAC_PI_2);
    for (at, z) in [([1.0, 5.0], [3.0, 0.0]), ([0.0, 2.0], [1.0, FRAC_PI_2])] {
        assert!((expected(&pose, at).z - Vector2::from(z)).norm() < 1e-12, "{at:?}");
    }
    let z = expected(&pose, [2.0, 1.0]).z;
    assert!((z - Vector2::new(2.0_f64.sqrt(), -0.75 * PI)).norm() < 1e-12, "{z}");
    assert_eq!(LandmarkModel::expected(&pose, &Vector2::new(1.0, 2.01)), None);
    assert_eq!(LandmarkModel::expected(&pose, &Vector2::new(f64::NAN, 0.0)), None);
}

#[test]
fn a_bearing_behind_the_robot_is_compared_across_half_a_turn() {
    let behind = expected(&SE2::identity(), [-2.0, 2.0 * 1e-3]);
    let residual = behind.residual(&LandmarkReading::new(None, 2.1, -PI + 2e-3));
    assert!((residual.x - 0.1).abs() < 1e-6 && (residual.y - 3e-3).abs() < 1e-6, "{residual}");
}

#[test]
fn derivatives_are_those_of_finite_differences() {
    let poses = [SE2::new(0.3, -0.7, 0.4), SE2::new(-1.0, 2.0, 3.0), SE2::new(0.0, 0.0, -2.0)];
    for (pose, at) in poses.iter().flat_map(|p| [[2.0, 1.0], [-1.5, -0.2]].map(|at| (p, at))) {
        let of = expected(pose, at);
        for axis in 0..3 {
            let mut tau = Vector3::zeros();
            tau[axis] = 1e-6;
            let [plus, minus] = [tau, -tau].map(|tau| expected(&pose.boxplus(&tau), at).z);
            let slope = Vector2::new(plus.x - minus.x, wrap_angle(plus.y - minus.y)) / 2e-6;
            assert!((slope - of.by_pose.column(axis)).norm() < 1e-8, "{axis}: {slope}");
        }
        for axis in 0..2 {
            let moved = |by: f64| {
                let mut at = at;
                at[axis] += by;
                expected(pose, at).z
            };
            let (plus, minus) = (moved(1e-6), moved(-1e-6));
            let slope = Vector2::new(plus.x - minus.x, wrap_angle(plus.y - minus.y)) / 2e-6;
            assert!((slope - of.by_landmark.column(axis)).norm() < 1e-8, "{axis}: {slope}");
        }
    }
}

#[test]
fn a_reading_is_placed_where_it_is_expected() {
    let (pose, model) = (SE2::new(-1.0, 2.0, 2.5), model());
    let reading = LandmarkReading::new(None, 1.7, -2.2);
    let placed = model.place(&pose, &reading);
    let again = expected(&pose, placed.at.into());
    assert!(again.residual(&reading).norm() < 1e-12);
    // Both derivatives undo those of the reading: H_m G_τ = −H_τ, H_m G_z = 1.
    let h_g = again.by_landmark * placed.by_pose;
    assert!((h_g + again.by_pose).norm() < 1e-12, "{h_g}");
    let r = again.by_landmark * placed.covariance * again.by_landmark.transpose();
    assert!((r - model.r).norm() < 1e-15, "{r}");
    let of_pose: Matrix3x2<f64> = placed.by_pose.transpose();
    assert!((of_pose.row(2).norm() - 1.7).abs() < 1e-12, "{of_pose}");
}

fn candidate(landmark: usize, nis: f64, log_det: f64) -> Candidate {
    Candidate { landmark, nis, det: trig::exp(log_det) }
}

#[test]
fn the_likelier_landmark_is_chosen_and_an_ambiguous_one_refused() {
    let association = Association::new(&LandmarkOptions::default());
    // −2 ln(1 − p) for 0.99 and 0.99999, and 2 ln 10.
    assert!((association.inside - 9.210_340_37).abs() < 1e-8, "{association:?}");
    assert!((association.outside - 23.025_850_93).abs() < 1e-8, "{association:?}");
    let choose = |of: &[Candidate]| association.choose(of).0;
    assert_eq!(choose(&[]), Match::New);
    assert_eq!(choose(&[candidate(4, 9.2, 0.0)]), Match::Landmark(4));
    assert_eq!(choose(&[candidate(4, 9.3, 0.0)]), Match::Refused);
    assert_eq!(choose(&[candidate(4, 23.0, 0.0), candidate(5, 99.0, 0.0)]), Match::Refused);
    assert_eq!(choose(&[candidate(4, 23.1, 0.0)]), Match::New);
    // The second one is less likely by more, and by less, than the factor of 10.
    assert_eq!(choose(&[candidate(1, 6.0, 0.0), candidate(2, 1.3, 0.0)]), Match::Landmark(2));
    assert_eq!(choose(&[candidate(1, 5.8, 0.0), candidate(2, 1.3, 0.0)]), Match::Refused);
    // Of a larger nearness and a far larger S, the sharper landmark is likelier.
    assert_eq!(choose(&[candidate(1, 3.0, -9.0), candidate(2, 1.0, 0.0)]), Match::Landmark(1));
    // Outside the gate there is no rival.
    assert_eq!(choose(&[candidate(1, 9.0, 0.0), candidate(2, 9.3, -5.0)]), Match::Landmark(1));
}

#[test]
fn a_landmark_has_one_reading_and_nonsense_has_none() {
    let reading = |id, range_m| LandmarkReading::new(id, range_m, 0.0);
    let known = |id: u32| (id == 7).then_some(3);
    // The range is the NIS of landmark 3.
    let candidates = |reading: &LandmarkReading, found: &mut Vec<Candidate>| {
        found.push(candidate(3, reading.range_m, 0.0));
    };
    let options = LandmarkOptions::default();
    let matches = |options: &LandmarkOptions, readings: &[LandmarkReading]| {
        Association::new(options).matches(readings, known, candidates)
    };
    let (hit, new, refused) = (Match::Landmark(3), Match::New, Match::Refused);
    let three = [reading(None, 2.0), reading(None, 1.0), reading(None, 50.0)];
    assert_eq!(matches(&options, &three), [refused, hit, new]);
    assert_eq!(matches(&options, &[reading(None, 1.0); 2]), [hit, refused]);
    let named = [reading(Some(7), 8.0), reading(Some(9), 1.0)];
    assert_eq!(matches(&options, &named), [hit, new]);
    let ignoring = LandmarkOptions { ignore_ids: true, ..options };
    assert_eq!(matches(&ignoring, &named), [refused, hit]);
    for range_m in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
        assert_eq!(matches(&options, &[reading(Some(7), range_m)]), [refused], "{range_m}");
    }
    let unknown = LandmarkReading::new(Some(7), 1.0, f64::NAN);
    assert_eq!(matches(&options, &[unknown]), [refused]);
    let singular = Candidate::new(0, &Vector2::zeros(), &Matrix2::zeros());
    assert_eq!(singular, None);
}

#[test]
fn deviations_are_those_of_the_data_sheet_or_of_the_command_line() {
    let config =
        LandmarkSensorConfig { range_std_m: 0.1, bearing_std_rad: 0.2, ..Default::default() };
    let mut start = start(&ring());
    let r = |start: &Start, options: &LandmarkOptions| {
        let r = LandmarkModel::of_start(start, options).unwrap().r;
        [r[(0, 0)].sqrt(), r[(1, 1)].sqrt()]
    };
    let options = LandmarkOptions::default();
    for (sheet, stds) in [
        (DataSheet::Given, [0.1, 0.2]),
        (DataSheet::Nominal, [0.05, 0.035]),
        (DataSheet::Hidden, [0.05, 0.035]),
    ] {
        start.sensors.landmarks = Some(LandmarkSensorSheet::new(&config, sheet));
        let found = r(&start, &options);
        assert!(found.iter().zip(stds).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
    }
    let more = LandmarkOptions { range_std_m: Some(0.3), bearing_std_deg: Some(90.0), ..options };
    let found = r(&start, &more);
    assert!((found[0] - 0.3).abs() < 1e-12 && (found[1] - FRAC_PI_2).abs() < 1e-12, "{found:?}");
    start.sensors.landmarks = None;
    let refused = LandmarkModel::of_start(&start, &options).unwrap_err().to_string();
    assert!(refused.contains("[sensors.landmarks]"), "{refused}");
}
