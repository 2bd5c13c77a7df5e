//! FastSLAM: a particle by hand, and many of them on a loop.

use nalgebra::{Matrix2, Vector2};

use super::*;
use crate::Motion;
use crate::landmarks::test_robot::{Robot, Seeing, first_pose, follow, ring, start};

fn fastslam(options: &Options) -> FastSlam {
    let mut told = start(&ring());
    told.map = None;
    FastSlam::new(&told, options).unwrap()
}

const VARIANTS: [Variant; 2] = [Variant::One, Variant::Two];

#[test]
fn one_particle_without_noise_maps_from_known_poses() {
    let model = fastslam(&Options::default()).model;
    for variant in VARIANTS {
        // The same landmark from ten poses of a straight way, without noise.
        let (at, mut particle) = (Vector2::new(2.0, 1.0), Particle::default());
        let motion = Motion { now_in_then: SE2::new(0.1, 0.0, 0.05), ..Motion::default() };
        let (mut pose, mut information) = (SE2::identity(), Matrix2::zeros());
        for _ in 0..10 {
            pose = pose.compose(&motion.now_in_then);
            let expected = LandmarkModel::expected(&pose, &at).unwrap();
            let reading = LandmarkReading::new(Some(1), expected.z.x, expected.z.y);
            particle.step(&motion, &[reading], &model, variant, &Vector3::new(1.0, -1.0, 2.0));
            let h = expected.by_landmark;
            information += h.transpose() * model.r.try_inverse().unwrap() * h;
        }
        assert!((particle.pose.boxminus(&pose)).norm() < 1e-12);
        let landmark = particle.landmarks[0];
        assert!((landmark.at - at).norm() < 1e-9, "{landmark:?}");
        let wanted = information.try_inverse().unwrap();
        assert!((landmark.covariance - wanted).norm() < 1e-9 * wanted.norm(), "{landmark:?}");
    }
}

#[test]
fn a_particle_weighs_what_its_reading_is_worth() {
    let model = fastslam(&Options::default()).model;
    // A landmark 2 m ahead with a variance of 0.01 m² in each axis.
    let landmark = particle::Landmark {
        id: Some(1),
        at: Vector2::new(2.0, 0.0),
        covariance: Matrix2::identity() * 0.01,
    };
    let ahead = Particle { pose: SE2::identity(), landmarks: vec![landmark] };
    let weight = |range_m, variant, covariance| {
        let motion = Motion { covariance, ..Motion::default() };
        let reading = [LandmarkReading::new(Some(1), range_m, 0.0)];
        let mut particle = ahead.clone();
        let log = particle.step(&motion, &reading, &model, variant, &Vector3::zeros());
        (log, particle.pose)
    };
    // Q = 0.01 + 0.0025 for the range: a residual of 0.2 m costs 0.04 / Q / 2.
    let (exact, _) = weight(2.0, Variant::One, Matrix3::zeros());
    let (off, pose) = weight(2.2, Variant::One, Matrix3::zeros());
    assert!((exact - off - 1.6).abs() < 1e-9, "{exact} {off}");
    assert_eq!(pose, SE2::identity());
    // Variant 2 adds the variance of the motion, and draws near the reading: the share
    // 0.0375 / 0.05 of the residual.
    let along = Matrix3::from_diagonal(&Vector3::new(0.0375, 0.0, 0.0));
    let (exact, _) = weight(2.0, Variant::Two, along);
    let (off, pose) = weight(2.2, Variant::Two, along);
    assert!((exact - off - 0.04 / 0.05 / 2.0).abs() < 1e-9, "{exact} {off}");
    assert!((pose.x() + 0.15).abs() < 1e-9, "{pose:?}");
}

#[test]
fn the_mean_of_headings_across_half_a_turn_is_half_a_turn() {
    let at = |theta_rad| Particle { pose: SE2::new(1.0, 2.0, theta_rad), ..Particle::default() };
    let pi = std::f64::consts::PI;
    let (pose, covariance) = mean(&[at(pi - 0.1), at(0.3 - pi)], &[0.75, 0.25]);
    assert!((pose.theta().abs() - pi).abs() < 1e-12, "{pose:?}");
    // 0.75 · 0.1² + 0.25 · 0.3².
    assert!((covariance[(2, 2)] - 0.03 - LEAST).abs() < 1e-12, "{covariance}");
    assert_eq!(mean(&[], &[]).0, SE2::identity());
}

/// Root of the mean square over seeds of the errors of a filter and of the wheels, m.
fn errors_m(options: &Options, has_ids: bool, seeds: u64) -> (f64, f64) {
    let (mut of_filter, mut of_wheels) = (0.0, 0.0);
    for seed in 0..seeds {
        let mut filter = fastslam(options);
        let (rms_m, _) = follow(&mut filter, &mut Robot::new(&ring(), has_ids, seed), 1300);
        let mut robot = Robot::new(&ring(), has_ids, seed);
        let drive = rusty_geometry::DiffDrive::rusty();
        let mut wheels = Wheels(Odometry::new(drive, OdometryNoise::default()));
        let (wheels_m, _) = follow(&mut wheels, &mut robot, 1300);
        of_filter += rms_m * rms_m / seeds as f64;
        of_wheels += wheels_m * wheels_m / seeds as f64;
    }
    (of_filter.sqrt(), of_wheels.sqrt())
}

/// Dead reckoning.
struct Wheels(Odometry);

impl Seeing for Wheels {
    fn drive(&mut self, counts: EncoderCounts) {
        self.0.advance(counts);
    }

    fn look(&mut self, _: &[LandmarkReading]) {}

    fn answer(&self) -> (SE2, Matrix3<f64>) {
        let motion = self.0.so_far();
        (first_pose().compose(&motion.now_in_then), motion.covariance + Matrix3::identity() * LEAST)
    }
}

#[test]
fn both_versions_follow_two_rounds_with_identities_and_without() {
    for variant in VARIANTS {
        for has_ids in [true, false] {
            let options = Options { variant, particles: 100, ..Options::default() };
            let (slam_m, wheels_m) = errors_m(&options, has_ids, 6);
            assert!(3.0 * slam_m < wheels_m, "{variant:?} {has_ids}: {slam_m} m, {wheels_m} m");
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let run = |seed| {
        let mut filter = fastslam(&Options { seed, particles: 20, ..Options::default() });
        follow(&mut filter, &mut Robot::new(&ring(), false, 1), 300);
        (filter.pose(), filter.particles().to_vec())
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1).0, run(2).0);
}

#[test]
fn nonsense_leaves_weights_and_poses_usable() {
    let mut filter = fastslam(&Options { particles: 10, ..Options::default() });
    let reading = |range_m, bearing_rad| LandmarkReading::new(Some(1), range_m, bearing_rad);
    filter.see(&[reading(1.0, 0.0)]);
    filter.see(&[reading(f64::NAN, 0.0), reading(1e300, 0.0), reading(1.0, f64::INFINITY)]);
    filter.see(&[reading(1e-9, 0.0), reading(1.0, 0.0)]);
    let (pose, covariance) = filter.pose();
    assert!(pose.boxminus(&first_pose()).norm() < 1.0, "{pose:?}");
    assert!(covariance.iter().all(|v| v.is_finite()), "{covariance}");
    assert!((filter.weights.iter().sum::<f64>() - 1.0).abs() < 1e-9);
}
