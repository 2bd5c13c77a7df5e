//! EKF SLAM: against dense matrices, on a loop, and with provisional landmarks.

use nalgebra::{DMatrix, Matrix2, Vector3};

use super::*;
use crate::landmarks::test_robot::{Robot, first_pose, follow, ring, start};
use crate::{Motion, Random};

fn slam(options: &Options) -> EkfSlam {
    let mut told = start(&ring());
    told.map = None;
    EkfSlam::new(&told, options).unwrap()
}

/// The whole matrix.
fn dense(joint: &Joint) -> DMatrix<f64> {
    let size = 3 + 2 * joint.len();
    let of_landmark = |i: usize| ((i - 3) / 2, (i - 3) % 2);
    DMatrix::from_fn(size, size, |i, j| match (i < 3, j < 3) {
        (true, true) => joint.pose()[(i, j)],
        (true, false) => joint.cross(of_landmark(j).0)[(i, of_landmark(j).1)],
        (false, true) => joint.cross(of_landmark(i).0)[(j, of_landmark(i).1)],
        (false, false) => {
            joint.between(of_landmark(i).0, of_landmark(j).0)[(of_landmark(i).1, of_landmark(j).1)]
        }
    })
}

/// A pose and three landmarks that are related.
fn related() -> (Joint, LandmarkModel, SE2) {
    let (pose, model) = (SE2::new(0.4, -0.3, 0.7), slam(&Options::default()).model);
    let mut joint = Joint::new(&Matrix3::from_diagonal(&Vector3::new(0.01, 0.02, 0.03)));
    for (range_m, bearing_rad) in [(2.0, 0.3), (1.0, -2.0), (3.0, 1.5)] {
        joint.add(&model.place(&pose, &LandmarkReading::new(None, range_m, bearing_rad)));
        joint.predict(&motion());
    }
    (joint, model, pose)
}

fn motion() -> Motion {
    let a = Matrix3::new(0.3, 0.0, 0.0, 0.1, 0.2, 0.0, -0.4, 0.5, 0.1);
    Motion { now_in_then: SE2::new(0.3, 0.1, 0.4), covariance: a * a.transpose() * 1e-2 }
}

#[test]
fn the_sparse_updates_are_those_of_whole_matrices() {
    let (joint, model, pose) = related();
    let before = dense(&joint);
    let mut predicted = joint.clone();
    predicted.predict(&motion());
    let mut g = DMatrix::<f64>::identity(9, 9);
    g.view_mut((0, 0), (3, 3)).copy_from(&motion().now_in_then.inverse().adjoint());
    let mut expected = &g * &before * g.transpose();
    let with_noise = expected.view((0, 0), (3, 3)) + motion().covariance;
    expected.view_mut((0, 0), (3, 3)).copy_from(&with_noise);
    assert!((dense(&predicted) - expected).norm() < 1e-14);

    let of = LandmarkModel::expected(&pose, &Vector2::new(2.0, 1.0)).unwrap();
    let nu = Vector2::new(0.1, -0.05);
    let mut h = DMatrix::<f64>::zeros(2, 9);
    h.view_mut((0, 0), (2, 3)).copy_from(&of.by_pose);
    h.view_mut((0, 5), (2, 2)).copy_from(&of.by_landmark);
    let r = DMatrix::from_fn(2, 2, |i, j| model.r[(i, j)]);
    let s = &h * &before * h.transpose() + r;
    let k = &before * h.transpose() * s.clone().try_inverse().unwrap();
    let (p, x) = ((DMatrix::identity(9, 9) - &k * &h) * &before, &k * nu);
    let mut corrected = joint;
    let by = (&of.by_pose, &of.by_landmark);
    let correction = corrected.correct(1, by, &model.r, &nu).unwrap();
    assert!((dense(&corrected) - p).norm() < 1e-13);
    let nis = (nu.transpose() * s.try_inverse().unwrap() * nu)[(0, 0)];
    assert!((correction.nis - nis).abs() < 1e-12, "{correction:?}");
    for i in 0..3 {
        assert!((correction.tau[i] - x[i]).abs() < 1e-13);
        let change = correction.landmarks_m[i];
        assert!((change - Vector2::new(x[3 + 2 * i], x[4 + 2 * i])).norm() < 1e-13);
    }
    // What is not a number changes nothing.
    let same = corrected.clone();
    assert_eq!(corrected.correct(1, by, &(model.r * f64::NAN), &nu), None);
    assert_eq!(corrected.correct(1, by, &model.r, &(nu * f64::NAN)), None);
    assert_eq!(corrected, same);
}

#[test]
fn a_landmark_seen_n_times_from_a_known_pose_has_an_nth_of_the_variance() {
    let mut filter = slam(&Options::default());
    let reading = LandmarkReading::new(Some(1), 1.5, 0.8);
    let once = filter.model.place(&first_pose(), &reading);
    for n in 1..=100_u32 {
        filter.see(&[reading]);
        let found = filter.covariance().landmark(0) * f64::from(n);
        // The first pose is not quite exact.
        let rest = found - once.covariance;
        assert!(rest.norm() < 1e-3 * once.covariance.norm(), "{n}: {found}");
    }
    assert!((filter.landmarks()[0].at - once.at).norm() < 1e-9);
    assert_eq!(filter.landmarks().len(), 1);
}

#[test]
fn closing_the_loop_makes_every_landmark_more_certain() {
    for seed in 0..5 {
        let (mut filter, mut robot) = (slam(&Options::default()), Robot::new(&ring(), true, seed));
        let areas = |filter: &EkfSlam| -> Vec<f64> {
            (0..filter.landmarks().len()).map(|k| filter.covariance().landmark(k).trace()).collect()
        };
        let first = |r: &LandmarkReading, filter: &EkfSlam| r.id() == filter.landmarks()[0].id;
        let (mut is_away, mut closed) = (false, false);
        for tick in 0..700 {
            filter.advance(robot.drive());
            if tick % 5 > 0 {
                continue;
            }
            let readings = robot.look();
            let sees_first = tick > 0 && readings.iter().any(|r| first(r, &filter));
            is_away |= tick > 0 && !sees_first;
            if is_away && sees_first {
                let before = areas(&filter);
                filter.see(&readings);
                let after = areas(&filter);
                let newest = before.len() - 1;
                assert!(newest >= 7, "seed {seed}: {newest}");
                assert!(before.iter().zip(&after).all(|(b, a)| a < b), "{before:?} {after:?}");
                // The newest landmarks know least, and learn most.
                assert!(after[newest] < 0.9 * before[newest], "{before:?} {after:?}");
                closed = true;
                break;
            }
            filter.see(&readings);
        }
        assert!(closed, "seed {seed}: no loop");
    }
}

#[test]
fn pose_and_map_are_as_exact_as_it_says_with_identities_and_without() {
    for has_ids in [true, false] {
        let (runs, mut nees, mut of_map) = (20_u32, 0.0, 0.0);
        let mut squares_m2 = 0.0;
        for seed in 0..u64::from(runs) {
            let (mut filter, mut robot) =
                (slam(&Options::default()), Robot::new(&ring(), has_ids, seed));
            let (rms_m, of_run) = follow(&mut filter, &mut robot, 900);
            assert!(rms_m < 0.3, "ids {has_ids}, seed {seed}: {rms_m} m");
            squares_m2 += rms_m * rms_m / f64::from(runs);
            assert_eq!(filter.landmarks().len(), 10, "ids {has_ids}, seed {seed}");
            nees += of_run / f64::from(runs);
            for (k, landmark) in filter.landmarks().iter().enumerate() {
                let off = |l: &rusty_geometry::Landmark| Vector2::from(l.at) - landmark.at;
                let nearest = ring().iter().map(off).min_by(|a, b| a.norm().total_cmp(&b.norm()));
                let (nearest, p) = (nearest.unwrap(), filter.covariance().landmark(k));
                of_map += nearest.dot(&(p.try_inverse().unwrap() * nearest));
            }
            // Still positive definite.
            assert!(dense(filter.covariance()).cholesky().is_some(), "seed {seed}");
        }
        // Dead reckoning has 0.4 m.
        assert!(squares_m2.sqrt() < 0.12, "ids {has_ids}: {} m", squares_m2.sqrt());
        // Errors of neighbouring moments are related, so the band is wide.
        assert!((1.5..6.0).contains(&nees), "ids {has_ids}: {nees} of 3");
        let of_landmark = of_map / f64::from(10 * runs);
        assert!(of_landmark < 4.0, "ids {has_ids}: {of_landmark} of 2");
    }
}

#[test]
fn a_landmark_without_identity_is_provisional_until_it_was_seen_often() {
    let reading = LandmarkReading::new(None, 1.5, 0.8);
    let mut filter = slam(&Options::default());
    for looks in 1..=4 {
        let used = filter.see(&[reading]);
        assert_eq!(filter.landmarks().len(), usize::from(looks >= 3), "{looks}");
        assert_eq!(used.is_some(), looks >= 4, "{looks}");
    }
    // Two readings of one tick are of two landmarks, however near.
    let mut filter = slam(&Options { sightings: 2, ..Options::default() });
    filter.see(&[reading, LandmarkReading::new(None, 1.5, 0.81)]);
    assert!(filter.landmarks().is_empty());
    // A ghost is forgotten: its second reading comes too late.
    let mut filter = slam(&Options { sightings: 2, ..Options::default() });
    filter.see(&[reading]);
    (0..30).for_each(|_| assert_eq!(filter.see(&[]), None));
    filter.see(&[reading]);
    assert!(filter.landmarks().is_empty());
    filter.see(&[reading]);
    assert_eq!(filter.landmarks().len(), 1);
}

#[test]
fn nonsense_changes_nothing_and_the_map_is_bounded() {
    let mut filter = slam(&Options::default());
    let mut random = Random::new(1, 1);
    let nonsense = [f64::NAN, f64::INFINITY, -1.0, 1e-9]
        .map(|range_m| LandmarkReading::new(Some(1), range_m, random.uniform()));
    assert_eq!(filter.see(&nonsense), None);
    assert!(filter.landmarks().is_empty());
    for id in 0..MOST_LANDMARKS as u32 + 5 {
        filter.see(&[LandmarkReading::new(Some(id), 1.0 + f64::from(id % 7), 0.3)]);
    }
    assert_eq!((filter.landmarks().len(), filter.covariance().len()), (1000, 1000));
    let own: Matrix2<f64> = filter.covariance().landmark(999);
    assert!(own.iter().all(|v| v.is_finite()), "{own}");
}
