//! A robot that is driven through a world, and what scan matching says of it.

use nalgebra::{Matrix3, Vector3};
use rusty_contract::Start;
use rusty_contract::config::LidarConfig;
use rusty_geometry::{
    DiffDrive, EncoderCounts, Material, SE2, Scan, Twist, WallSpec, World, WorldSpec, apartment,
};

use super::*;
use crate::Random;
use crate::told_tests::told;

/// What a filter is told of a run in which nothing is given but the start.
pub(crate) fn start(lidar: &LidarConfig, initial_pose: Option<SE2>) -> Start {
    Start { lidar: (*lidar).into(), initial_pose, ..told("filter") }
}

/// A robot with wheels that slip, and a laser with noise.
pub(crate) struct Robot {
    world: World,
    pub(crate) lidar: LidarConfig,
    pub(crate) pose: SE2,
    way_m: [f64; 2],
    /// How much a wheel slips in a tick, one deviation, as a part of its way.
    slip: f64,
    random: Random,
}

impl Robot {
    pub(crate) fn new(world: World, pose: SE2, seed: u64) -> Self {
        let lidar = LidarConfig { dropout: 0.02, ..LidarConfig::default() };
        Self { world, lidar, pose, way_m: [0.0; 2], slip: 0.02, random: Random::new(seed, 1) }
    }

    /// Drives for a tick of 0.02 s; the counts at its end.
    pub(crate) fn drive(&mut self, twist: Twist) -> EncoderCounts {
        let drive = DiffDrive::rusty();
        let ways = self.turn_wheels(twist);
        let floor = ways.map(|way| way * (1.0 + self.slip * self.random.normal()));
        self.pose = self.pose.boxplus(&drive.tangent(floor[0], floor[1]));
        self.counts()
    }

    /// Turns the wheels for a tick while something holds the robot; the counts at its end.
    fn drive_held(&mut self, twist: Twist) -> EncoderCounts {
        let _ = self.turn_wheels(twist);
        self.counts()
    }

    /// The ways of the wheels' rims in a tick, m.
    fn turn_wheels(&mut self, twist: Twist) -> [f64; 2] {
        let drive = DiffDrive::rusty();
        let rates = drive.wheel_rates(twist);
        let ways = [rates.left_rad_s, rates.right_rad_s].map(|r| 0.02 * r * drive.wheel_radius_m);
        self.way_m = [self.way_m[0] + ways[0], self.way_m[1] + ways[1]];
        ways
    }

    fn counts(&self) -> EncoderCounts {
        let drive = DiffDrive::rusty();
        let around_m = std::f64::consts::TAU * drive.wheel_radius_m;
        let counts = self.way_m.map(|m| (m / around_m * drive.ticks_per_rev as f64).floor() as i64);
        EncoderCounts { left: counts[0], right: counts[1] }
    }

    /// What the laser says.
    pub(crate) fn look(&mut self) -> Vec<f64> {
        let mut scan = Scan::new(self.lidar.fan());
        scan.take(&self.world, &self.pose, self.lidar.range_max_m);
        let (max_m, std_m) = (self.lidar.range_max_m, self.lidar.range_std_m);
        let reading = |(range_m, wall): (f64, Option<usize>)| {
            let is_lost = self.random.uniform() < self.lidar.dropout;
            let noisy = range_m + std_m * self.random.normal();
            if wall.is_none() || is_lost { max_m } else { noisy }
        };
        scan.distances_and_walls().map(reading).collect()
    }
}

/// The world within these bounds that has walls from (x, y) to (x, y) each, m.
pub(crate) fn world_of(bounds: [f64; 4], walls: &[[f64; 4]]) -> World {
    let wall = |&[x, y, to_x, to_y]: &[f64; 4]| WallSpec {
        a: [x, y],
        b: [to_x, to_y],
        material: Material::Wall,
    };
    let (name, walls) = ("test".to_owned(), walls.iter().map(wall).collect());
    World::new(WorldSpec { name, bounds, walls, landmarks: Vec::new() }).unwrap()
}

/// Two parallel walls, 60 m long.
pub(crate) fn corridor() -> World {
    let walls = [[-30.0, -0.6, 30.0, -0.6], [-30.0, 0.6, 30.0, 0.6]];
    world_of([-30.0, -1.0, 30.0, 1.0], &walls)
}

/// A corridor with ends.
fn closed_corridor() -> World {
    let sides = [[-0.5, -0.6, 8.0, -0.6], [-0.5, 0.6, 8.0, 0.6]];
    let ends = [[-0.5, -0.6, -0.5, 0.6], [8.0, -0.6, 8.0, 0.6]];
    world_of([-1.0, -1.0, 8.5, 1.0], &[sides, ends].concat())
}

fn ahead(k: usize) -> Twist {
    // A weave: 0.5 m/s, to and fro.
    Twist { v_m_s: 0.5, omega_rad_s: if k % 100 < 50 { 0.3 } else { -0.3 } }
}

#[test]
fn errors_are_as_large_as_it_says() {
    // Four seconds through the largest room, two dozen times.
    let (mut sum, runs) = (0.0, 24);
    for seed in 0..runs {
        let mut robot = Robot::new(apartment(), SE2::new(8.0, 2.0, 1.0), seed);
        let mut filter =
            ScanMatch::new(&start(&robot.lidar, Some(robot.pose)), &ScanMatchOptions::default());
        for k in 0..200 {
            filter.advance(robot.drive(ahead(k)));
            if k % 5 == 4 {
                let told = filter.scan(&robot.look());
                assert_eq!(told.no_match, None);
            }
        }
        let (pose, covariance) = filter.pose();
        let error = robot.pose.boxminus(&pose);
        assert!(error.norm() < 0.06, "{seed}: {error}");
        sum += (error.transpose() * covariance.try_inverse().unwrap() * error).x;
    }
    // Neighbouring motions share a scan, and their errors partly cancel: less than
    // 3 is expected, and more than chance allows is not.
    let anees = sum / runs as f64;
    assert!((0.7..3.8).contains(&anees), "{anees}");
}

#[test]
fn uncertainty_grows_with_the_way() {
    let mut robot = Robot::new(apartment(), SE2::new(8.0, 2.0, 1.0), 5);
    let mut filter = ScanMatch::new(&start(&robot.lidar, None), &ScanMatchOptions::default());
    let mut volumes = Vec::new();
    for k in 0..300 {
        filter.advance(robot.drive(Twist { v_m_s: 0.5, omega_rad_s: 0.5 }));
        if k % 5 == 0 && filter.scan(&robot.look()).key.is_some() {
            volumes.push(filter.pose().1.determinant());
        }
    }
    assert!(volumes.len() > 4, "{volumes:?}");
    assert!(volumes.windows(2).all(|pair| pair[1] >= pair[0]), "{volumes:?}");
    // Without a start it begins at the origin of a separate frame.
    let (pose, _) = ScanMatch::new(&start(&robot.lidar, None), &ScanMatchOptions::default()).pose();
    assert_eq!(pose, SE2::identity());
}

#[test]
fn a_narrow_view_does_not_carry_it_away() {
    for omega_rad_s in [0.4, -0.4] {
        let mut sum = 0.0;
        for seed in 0..8 {
            let mut robot = Robot::new(apartment(), SE2::new(8.0, 2.0, 1.0), seed);
            robot.lidar = LidarConfig { fov_rad: 0.4, first_bearing_rad: -0.2, ..robot.lidar };
            let error = narrow_drive(&mut robot, omega_rad_s);
            assert!(error.xy().norm() < 0.25 && error.z.abs() < 0.3, "{seed}: {error}");
            sum += error.z * error.z;
        }
        // What is taken off for errors of normals, without noise: 0.37 and 1.06.
        let rms_rad = (sum / 8.0f64).sqrt();
        assert!(rms_rad < 0.17, "{omega_rad_s}: {rms_rad}");
    }
}

/// Drives for 40 s, turning; how far from the truth the answer is then.
fn narrow_drive(robot: &mut Robot, omega_rad_s: f64) -> Vector3<f64> {
    let mut filter =
        ScanMatch::new(&start(&robot.lidar, Some(robot.pose)), &ScanMatchOptions::default());
    let (mut matched, mut since_key_rad, mut late) = (0, 0.0f64, 0);
    for k in 0..2000 {
        let before = robot.pose.theta();
        filter.advance(robot.drive(Twist { v_m_s: 0.3, omega_rad_s }));
        since_key_rad += rusty_geometry::wrap_angle(robot.pose.theta() - before);
        if k % 5 == 4 {
            let told = filter.scan(&robot.look());
            matched += u32::from(told.no_match.is_none());
            if told.key.is_some() {
                since_key_rad = 0.0;
            }
            // Half of the view, and what it turns from one scan to the next.
            late += u32::from(since_key_rad.abs() > 0.3);
        }
    }
    assert!(matched > 320, "{matched} of 400");
    assert!(late < 20, "{late} of 400");
    robot.pose.boxminus(&filter.pose().0)
}

#[test]
fn few_beams_do_not_carry_it_away() {
    let mut sum = 0.0;
    for seed in 0..16 {
        let mut robot = Robot::new(apartment(), SE2::new(10.4, 3.0, 1.57), seed);
        robot.lidar = LidarConfig { beams: 20, ..robot.lidar };
        let mut filter =
            ScanMatch::new(&start(&robot.lidar, Some(robot.pose)), &ScanMatchOptions::default());
        for k in 0..2000 {
            filter.advance(robot.drive(Twist { v_m_s: 0.5, omega_rad_s: 0.6 }));
            if k % 5 == 4 {
                filter.scan(&robot.look());
            }
        }
        let error = robot.pose.boxminus(&filter.pose().0);
        sum += error.norm_squared();
    }
    let rms = (sum / 16.0f64).sqrt();
    // Searched as scans of many beams are: 0.097.
    assert!(rms < 0.085, "{rms}");
}

#[test]
fn a_corridor_does_not_carry_it_away() {
    let mut robot = Robot::new(corridor(), SE2::new(-10.0, 0.0, 0.0), 3);
    let mut filter =
        ScanMatch::new(&start(&robot.lidar, Some(robot.pose)), &ScanMatchOptions::default());
    for k in 0..1000 {
        filter.advance(robot.drive(Twist { v_m_s: 0.5, omega_rad_s: 0.0 }));
        if k % 5 == 4 {
            filter.scan(&robot.look());
        }
    }
    let (pose, covariance) = filter.pose();
    let error = robot.pose.boxminus(&pose);
    let deviation = |k: usize| covariance[(k, k)].sqrt();
    // Ten metres: the walls tell heading and side, the wheels alone how far.
    assert!(error.x.abs() < 0.1 && error.y.abs() < 0.15 && error.z.abs() < 0.02, "{error}");
    assert!(deviation(0) > 0.02, "{covariance}");
    assert!((0..3).all(|k| error[k].abs() < 3.0 * deviation(k)), "{error}, {covariance}");
}

#[test]
fn scans_that_say_nothing_leave_the_wheels() {
    let lidar = LidarConfig::default();
    let here = SE2::new(1.0, 2.0, 0.3);
    let mut robot = Robot::new(apartment(), here, 9);
    let mut filter = ScanMatch::new(&start(&lidar, Some(here)), &ScanMatchOptions::default());
    let mut odometry = rusty_clients::dead_reckoning::DeadReckoning::new(DiffDrive::rusty(), here);
    let mut two = vec![8.0; 180];
    (two[10], two[100]) = (1.0, 2.0);
    let scans = [vec![8.0; 180], two, vec![f64::NAN; 180], vec![0.0; 180], vec![]];
    for k in 0..100 {
        let counts = robot.drive(Twist { v_m_s: 0.4, omega_rad_s: 0.2 });
        filter.advance(counts);
        let expected = odometry.advance(counts);
        let told = filter.scan(&scans[k % scans.len()]);
        assert!(told.key.is_none() && told.innovation.is_none(), "{told:?}");
        let (pose, covariance) = filter.pose();
        assert!(pose.boxminus(&expected).norm() < 1e-9, "{pose:?} for {expected:?}");
        assert!(covariance[(2, 2)] > 0.0 && covariance == covariance.transpose());
    }
    // Once there was a scan, a blind one is named, and the wheels go on.
    let told = filter.scan(&robot.look());
    assert!(told.key.is_some());
    for ranges_m in &scans {
        filter.advance(robot.drive(Twist { v_m_s: 0.4, omega_rad_s: 0.2 }));
        let told = filter.scan(ranges_m);
        assert!(matches!(told.no_match, Some(NoMatch::FewEnds { .. })), "{told:?}");
        assert!(filter.pose().0.is_finite());
    }
}

#[test]
fn wheels_that_turn_on_the_spot_take_it_nowhere() {
    for seed in 0..6 {
        let mut robot = Robot::new(apartment(), SE2::new(8.0, 2.0, 1.0), seed);
        let mut filter =
            ScanMatch::new(&start(&robot.lidar, Some(robot.pose)), &ScanMatchOptions::default());
        // Something holds the robot for 2 s of 6: the wheels turn on for a metre.
        for k in 0..300 {
            let counts = match k {
                100..200 => robot.drive_held(Twist { v_m_s: 0.5, omega_rad_s: 0.0 }),
                _ => robot.drive(Twist { v_m_s: 0.2, omega_rad_s: 0.3 }),
            };
            filter.advance(counts);
            if k % 5 == 4 {
                filter.scan(&robot.look());
            }
        }
        let error = robot.pose.boxminus(&filter.pose().0);
        assert!(error.norm() < 0.1, "{seed}: {error}");
    }
}

#[test]
fn wheels_that_turn_on_the_spot_do_not_drive_it_along_a_corridor() {
    let mut errors_m = Vec::new();
    for seed in 0..12 {
        let mut robot = Robot::new(closed_corridor(), SE2::new(1.0, 0.1, 0.1), seed);
        robot.slip = 0.3;
        let mut filter =
            ScanMatch::new(&start(&robot.lidar, Some(robot.pose)), &ScanMatchOptions::default());
        // After 3 s something holds the robot, and the wheels turn on for 4.5 m.
        let mut most_m: f64 = 0.0;
        for k in 0..600 {
            let twist = Twist { v_m_s: 0.5, omega_rad_s: 0.0 };
            filter.advance(if k < 150 { robot.drive(twist) } else { robot.drive_held(twist) });
            if k % 5 == 4 {
                filter.scan(&robot.look());
                most_m = most_m.max(robot.pose.boxminus(&filter.pose().0).xy().norm());
            }
        }
        // Three slip through a wall, and see that one only: nothing tells that they stand.
        if robot.pose.y().abs() < 0.6 {
            errors_m.push(most_m);
        }
    }
    // Few beams meet the ends. If no match is compared with the one before it: 4.5 m.
    errors_m.sort_by(f64::total_cmp);
    assert!(errors_m.len() == 9 && errors_m[4] < 0.2 && errors_m[8] < 2.0, "{errors_m:.2?}");
}

#[test]
fn a_robot_that_stands_stays() {
    let mut robot = Robot::new(apartment(), SE2::new(8.0, 2.0, 1.0), 4);
    let mut filter =
        ScanMatch::new(&start(&robot.lidar, Some(robot.pose)), &ScanMatchOptions::default());
    let mut keys = 0;
    for _ in 0..50 {
        filter.advance(EncoderCounts::default());
        keys += u32::from(filter.scan(&robot.look()).key.is_some());
        assert_eq!(filter.pose(), (SE2::new(8.0, 2.0, 1.0), Matrix3::zeros()));
    }
    assert_eq!(keys, 1);
}

#[test]
fn what_is_believed_of_the_start_is_in_the_answer() {
    let options = ScanMatchOptions { start_std_m: 0.3, start_std_deg: 2.0, ..Default::default() };
    let at = SE2::new(8.0, 2.0, 1.0);
    let unsure = independent(0.3, 2.0f64.to_radians());
    for (told, expected) in [(Some(at), unsure), (None, Matrix3::zeros())] {
        let mut robot = Robot::new(apartment(), at, 4);
        let mut filter = ScanMatch::new(&start(&robot.lidar, told), &options);
        filter.advance(EncoderCounts::default());
        filter.scan(&robot.look());
        let (_, covariance) = filter.pose();
        assert!((covariance - expected).norm() < 1e-12, "{covariance}");
    }
}
