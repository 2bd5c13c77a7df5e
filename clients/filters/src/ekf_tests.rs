//! The EKF on a simple separate world: errors as large as it says, the same
//! bits twice, and a sane answer to whatever comes.

use nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};
use rusty_contract::LidarConfig;
use rusty_geometry::{DiffDrive, Scan, Twist, World};
use rusty_metrics::chi_square::quantile;

use super::*;
use crate::Random;
use crate::told_tests::told;

fn start(map: bool, initial_pose: Option<SE2>) -> Start {
    let map = map.then(|| rusty_geometry::apartment().spec().clone());
    Start { map, initial_pose, ..told("ekf") }
}

/// Where a χ² of these degrees is, but for one time in a hundred.
fn within(value: f64, degrees: f64) -> bool {
    quantile(0.005, degrees) < value && value < quantile(0.995, degrees)
}

/// A robot that slips, and what it tells.
struct Robot {
    world: World,
    lidar: LidarConfig,
    scan: Scan,
    pose: SE2,
    angles_rad: [f64; 2],
    random: Random,
}

impl Robot {
    fn new(pose: SE2, seed: u64) -> Self {
        let (world, lidar) = (rusty_geometry::apartment(), LidarConfig::default());
        let (scan, random) = (Scan::new(lidar.fan()), Random::new(seed, 99));
        Self { world, lidar, scan, pose, angles_rad: [0.0; 2], random }
    }

    fn drive(&mut self, twist: Twist, slip_std: f64) -> EncoderCounts {
        let (drive, dt_s) = (DiffDrive::rusty(), 0.02);
        let rates = drive.wheel_rates(twist);
        let turned = [rates.left_rad_s * dt_s, rates.right_rad_s * dt_s];
        let ground = turned
            .map(|angle| drive.wheel_radius_m * angle * (1.0 + slip_std * self.random.normal()));
        self.pose = self.pose.boxplus(&drive.tangent(ground[0], ground[1]));
        self.angles_rad = [self.angles_rad[0] + turned[0], self.angles_rad[1] + turned[1]];
        EncoderCounts::from_wheel_angles(self.angles_rad, drive.ticks_per_rev)
    }

    fn look(&mut self) -> Vec<f64> {
        self.scan.take(&self.world, &self.pose, self.lidar.range_max_m);
        let distances = self.scan.distances_and_walls().map(|(distance_m, _)| distance_m);
        let exact: Vec<f64> = distances.collect();
        let (std_m, max_m) = (self.lidar.range_std_m, self.lidar.range_max_m);
        let noisy = exact.into_iter().map(|exact_m| {
            let (z, u) = (self.random.normal(), self.random.uniform());
            if exact_m >= max_m || u < 0.02 { max_m } else { (exact_m + std_m * z).min(max_m) }
        });
        noisy.collect()
    }
}

/// Drives a circle in the living room; the filter, and the last NEES.
fn run(seed: u64, ticks: usize) -> (Ekf, f64, Innovation) {
    let from = SE2::new(9.6, 2.0, 0.0);
    let (mut robot, options) = (Robot::new(from, seed), Options::default());
    // The start is as wrong as the filter is told.
    let told = from.boxplus(&Vector3::from_fn(|i, _| {
        let std = if i < 2 { 0.02 } else { 1.0_f64.to_radians() };
        std * robot.random.normal()
    }));
    let mut ekf = Ekf::new(&start(true, Some(told)), &options).unwrap();
    let mut sum = Innovation { nis: 0.0, degrees: 0 };
    for tick in 0..ticks {
        // 5 % in 8 mm has the variance of the default, 2 % in 5 cm.
        ekf.advance(robot.drive(Twist { v_m_s: 0.4, omega_rad_s: 0.4 }, 0.05));
        if tick % 5 == 0 {
            let ranges_m = robot.look();
            if let Some(of_scan) = ekf.scan(&ranges_m) {
                sum.nis += of_scan.nis;
                sum.degrees += of_scan.degrees;
            }
        }
    }
    let tau = robot.pose.boxminus(&ekf.pose_in_world());
    let nees = tau.dot(&(ekf.covariance().try_inverse().unwrap() * tau));
    (ekf, nees, sum)
}

#[test]
fn errors_are_as_large_as_it_says() {
    let runs = 100_u32;
    let (mut nees, mut nis, mut degrees) = (0.0, 0.0, 0.0);
    for seed in 0..u64::from(runs) {
        let (ekf, of_run, innovation) = run(seed, 150);
        assert!(ekf.covariance().diagonal().max() < 0.02 * 0.02, "{}", ekf.covariance());
        nees += of_run;
        nis += innovation.nis;
        degrees += f64::from(innovation.degrees);
    }
    assert!(within(nees, 3.0 * f64::from(runs)), "NEES {nees}");
    // At least three walls a scan.
    assert!(degrees > 6.0 * 30.0 * f64::from(runs), "{degrees}");
    assert!(within(nis, degrees), "NIS {nis} of {degrees}");
}

#[test]
fn the_same_run_gives_the_same_bits() {
    let ((a, ..), (b, ..)) = (run(3, 60), run(3, 60));
    let bits = |ekf: &Ekf| {
        let (p, covariance) = (ekf.pose_in_world(), ekf.covariance());
        let numbers = [p.x(), p.y(), p.theta()].into_iter().chain(covariance.iter().copied());
        numbers.map(f64::to_bits).collect::<Vec<_>>()
    };
    assert_eq!(bits(&a), bits(&b));
}

#[test]
fn joseph_s_form_is_the_plain_one_and_stays_symmetric() {
    let covariance = Matrix3::new(4e-4, 1e-5, -2e-5, 1e-5, 9e-4, 3e-5, -2e-5, 3e-5, 1e-4);
    let h = Matrix2x3::new(0.0, 0.0, -1.0, -0.6, -0.8, 0.7);
    let r = Matrix2::new(1e-4, 0.0, 0.0, 5e-5);
    let s = h * covariance * h.transpose() + r;
    // Without a surprise nothing is carried to another tangent space.
    let innovation = LineInnovation { nu: Vector2::zeros(), h, r, s };
    let (pose, after) = updated(&SE2::new(1.0, 2.0, 3.0), &covariance, &innovation).unwrap();
    let gain = covariance * h.transpose() * s.try_inverse().unwrap();
    let plain = (Matrix3::identity() - gain * h) * covariance;
    assert!((after - plain).norm() < 1e-15, "{after} {plain}");
    assert_eq!(after, after.transpose());
    assert_eq!(pose, SE2::new(1.0, 2.0, 3.0));
    // And information adds up: P⁻¹ grows by Hᵀ R⁻¹ H.
    let information =
        covariance.try_inverse().unwrap() + h.transpose() * r.try_inverse().unwrap() * h;
    assert!((after - information.try_inverse().unwrap()).norm() < 1e-12);
}

#[test]
fn the_error_is_carried_to_the_new_tangent_space() {
    // exp(τ + ε) = exp(τ) exp(Jr ε), by finite differences.
    let (tau, step) = (Vector3::new(0.05, -0.03, 0.08), 1e-6);
    let columns = std::array::from_fn::<_, 3, _>(|column| {
        let mut more = tau;
        more[column] += step;
        SE2::exp(&more).boxminus(&SE2::exp(&tau)) / step
    });
    let found = Matrix3::from_columns(&columns);
    // The next term of the series is ad²/6.
    assert!((found - right_jacobian(&tau)).norm() < 0.003, "{found}");
    assert!((found - right_jacobian(&-tau)).norm() > 0.05);
}

#[test]
fn without_walls_it_predicts_and_without_a_start_it_says_so() {
    let mut ekf = Ekf::new(&start(false, Some(SE2::identity())), &Options::default()).unwrap();
    let before = ekf.covariance().trace();
    ekf.advance(EncoderCounts { left: 1000, right: 1200 });
    assert_eq!(ekf.scan(&[1.0; 180]), None);
    assert!(ekf.covariance().trace() > before && ekf.pose_in_world().x() > 0.05);
    let refused = Ekf::new(&start(true, None), &Options::default()).unwrap_err().to_string();
    assert!(refused.contains("initial_pose = \"given\"") && refused.contains("mcl"), "{refused}");
}

#[test]
fn nonsense_moves_nothing_and_is_never_answered_with_nan() {
    let mut ekf =
        Ekf::new(&start(true, Some(SE2::new(6.0, 4.5, 0.0))), &Options::default()).unwrap();
    let pose = ekf.pose_in_world();
    for ranges_m in [vec![], vec![f64::NAN; 180], vec![8.0; 180], vec![0.0; 180], vec![-1.0; 7]] {
        assert_eq!(ekf.scan(&ranges_m), None);
        assert_eq!(ekf.pose_in_world(), pose);
    }
    // A laser without error, exactly where it thinks: no division by zero.
    let mut exact = start(true, Some(SE2::new(6.0, 4.5, 0.0)));
    exact.lidar.range_std_m = Some(0.0);
    let mut ekf = Ekf::new(&exact, &Options::default()).unwrap();
    let mut robot = Robot::new(SE2::new(6.0, 4.5, 0.0), 1);
    robot.lidar.range_std_m = 0.0;
    for _ in 0..50 {
        let ranges_m = robot.look();
        assert!(ekf.scan(&ranges_m).is_some());
    }
    assert!(ekf.pose_in_world().boxminus(&robot.pose).norm() < 1e-4);
    assert!(ekf.covariance().iter().all(|v| v.is_finite()));
    assert!(ekf.covariance().diagonal().min() >= 0.0);
}

/// Scans after which a robot that was put elsewhere has no answer any more, and from then
/// on to the next; and the largest error of an answer after the first of them, m.
fn carried_to(place: SE2, seed: u64) -> (Option<usize>, Option<usize>, f64) {
    let from = SE2::new(9.6, 2.0, 0.0);
    let mut robot = Robot::new(from, seed);
    let mut ekf = Ekf::new(&start(true, Some(from)), &Options::default()).unwrap();
    let (mut lost, mut found, mut error_m) = (None, None, 0.0_f64);
    for scan in 0..120 {
        if scan == 30 {
            robot.pose = place;
        }
        for _ in 0..5 {
            ekf.advance(robot.drive(Twist { v_m_s: 0.3, omega_rad_s: 0.6 }, 0.02));
        }
        let ranges_m = robot.look();
        ekf.scan(&ranges_m);
        match (ekf.is_lost(), lost) {
            (true, None) => lost = Some(scan - 30),
            (false, Some(since)) => {
                found = found.or(Some(scan - 30 - since));
                let off_m = (ekf.pose_in_world().translation() - robot.pose.translation()).norm();
                error_m = error_m.max(off_m);
            }
            _ => {}
        }
    }
    (lost, found, error_m)
}

#[test]
fn a_robot_put_elsewhere_is_not_answered_for_until_it_is_found() {
    let places = [SE2::new(9.0, 5.5, 2.0), SE2::new(1.6, 6.6, -1.2), SE2::new(8.6, 2.6, 1.5)];
    for (seed, place) in (0..8).flat_map(|seed| places.map(|place| (seed, place))) {
        let (lost, found, error_m) = carried_to(place, seed);
        assert!(lost.is_some_and(|scans| scans <= 20), "{seed}, {place:?}: {lost:?}");
        assert!(found.is_some_and(|scans| scans <= 80), "{seed}, {place:?}: {found:?}");
        assert!(error_m < 0.1, "{seed}, {place:?}: {error_m} m");
    }
}

#[test]
fn while_something_holds_the_robot_its_wheels_are_not_believed() {
    for seed in 0..8 {
        let from = SE2::new(9.6, 2.0, 0.0);
        let mut robot = Robot::new(from, seed);
        let mut ekf = Ekf::new(&start(true, Some(from)), &Options::default()).unwrap();
        // From driving to held and on, and from there to held while it turns.
        for scan in 0..60 {
            let twist = Twist { v_m_s: 0.5, omega_rad_s: if scan < 40 { 0.3 } else { 1.5 } };
            let is_held = scan % 20 >= 10;
            for _ in 0..5 {
                let stands = robot.pose;
                ekf.advance(robot.drive(twist, 0.02));
                if is_held {
                    robot.pose = stands;
                }
            }
            let off_m = || (robot.pose.translation() - ekf.pose_in_world().translation()).norm();
            assert!(scan % 20 < 13 || off_m() < 0.03, "seed {seed}, before scan {scan}");
            let ranges_m = robot.look();
            ekf.scan(&ranges_m);
            let tau = robot.pose.boxminus(&ekf.pose_in_world());
            assert!(tau.norm() < 0.06, "seed {seed}, scan {scan}: {tau}");
            assert!(!ekf.is_lost(), "seed {seed}, scan {scan}");
        }
    }
}

#[test]
fn people_in_front_of_the_walls_are_no_reason_to_abstain() {
    let from = SE2::new(9.6, 2.0, 0.0);
    let lost = |off_m: f64| {
        let mut robot = Robot::new(from, 3);
        let mut ekf = Ekf::new(&start(true, Some(from)), &Options::default()).unwrap();
        (0..60).any(|scan| {
            for _ in 0..5 {
                ekf.advance(robot.drive(Twist { v_m_s: 0.0, omega_rad_s: 0.6 }, 0.02));
            }
            let mut ranges_m = robot.look();
            let seen = ranges_m.iter_mut().filter(|range_m| scan >= 20 && **range_m < 7.9);
            for (_, range_m) in seen.enumerate().filter(|(beam, _)| !beam.is_multiple_of(4)) {
                *range_m = (*range_m + off_m).max(0.3);
            }
            ekf.scan(&ranges_m);
            ekf.is_lost()
        })
    };
    assert!(!lost(-0.5));
    assert!(lost(0.5), "beams through walls");
}
