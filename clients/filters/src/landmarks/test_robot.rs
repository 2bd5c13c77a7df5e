//! A robot among landmarks, for the tests of filters: its wheels slip as the filters expect.

use nalgebra::Vector2;
use rusty_contract::config::sensors::LandmarkSensorConfig;
use rusty_contract::{LandmarkReading, Start};
use rusty_geometry::{DiffDrive, EncoderCounts, Landmark, SE2, Twist, trig, wrap_angle};

use crate::Random;
use crate::landmarks::LandmarkModel;
use crate::told_tests::told;

/// Start of the robot on a circle of 2.5 m radius around the origin.
pub(crate) fn first_pose() -> SE2 {
    SE2::new(0.0, -2.5, 0.0)
}

/// Ten landmarks, alternately inside and outside the circle.
pub(crate) fn ring() -> Vec<Landmark> {
    let turn = std::f64::consts::TAU / 10.0;
    let of = |k: u32| {
        let (s, c) = trig::sin_cos(turn * f64::from(k));
        let radius_m = if k.is_multiple_of(2) { 1.2 } else { 3.8 };
        Landmark { id: 50 + k, at: [radius_m * c, radius_m * s] }
    };
    (0..10).map(of).collect()
}

/// What a filter is told: the initial pose, the data sheet, and the landmarks as a map.
pub(crate) fn start(landmarks: &[Landmark]) -> Start {
    let mut start = Start { initial_pose: Some(first_pose()), ..told("landmarks") };
    let mut map = rusty_geometry::open().spec().clone();
    map.landmarks = landmarks.to_vec();
    start.map = Some(map);
    start.sensors.landmarks = Some(LandmarkSensorConfig::default().into());
    start
}

/// Slip of a wheel in a tick of 2.5 cm: 2e-5 m² per metre, as the filters expect.
const SLIP_STD: f64 = 0.0283;

/// A robot that slips, and its sensor: σ 0.05 m and 0.035 rad.
pub(crate) struct Robot {
    pub pose: SE2,
    landmarks: Vec<Landmark>,
    angles_rad: [f64; 2],
    has_ids: bool,
    random: Random,
}

impl Robot {
    /// At the first pose.
    pub fn new(landmarks: &[Landmark], has_ids: bool, seed: u64) -> Self {
        let (landmarks, random) = (landmarks.to_vec(), Random::new(seed, 99));
        Self { pose: first_pose(), landmarks, angles_rad: [0.0; 2], has_ids, random }
    }

    /// Drives for a tick, 628 of which are a round.
    pub fn drive(&mut self) -> EncoderCounts {
        let (drive, dt_s) = (DiffDrive::rusty(), 0.02);
        let rates = drive.wheel_rates(Twist { v_m_s: 1.25, omega_rad_s: 0.5 });
        let turned = [rates.left_rad_s * dt_s, rates.right_rad_s * dt_s];
        let slipped = |angle: f64, z: f64| drive.wheel_radius_m * angle * (1.0 + SLIP_STD * z);
        let z = [self.random.normal(), self.random.normal()];
        let ground = [slipped(turned[0], z[0]), slipped(turned[1], z[1])];
        self.pose = self.pose.boxplus(&drive.tangent(ground[0], ground[1]));
        self.angles_rad = [self.angles_rad[0] + turned[0], self.angles_rad[1] + turned[1]];
        EncoderCounts::from_wheel_angles(self.angles_rad, drive.ticks_per_rev)
    }

    /// The readings of all landmarks that are nearer than 2.5 m.
    pub fn look(&mut self) -> Vec<LandmarkReading> {
        let (pose, has_ids, random) = (self.pose, self.has_ids, &mut self.random);
        let of = |landmark: &Landmark| {
            let (z_range, z_bearing) = (random.normal(), random.normal());
            let expected = LandmarkModel::expected(&pose, &Vector2::from(landmark.at))?;
            let bearing_rad = wrap_angle(expected.z.y + 0.035 * z_bearing);
            let id = has_ids.then_some(landmark.id);
            let reading = LandmarkReading::new(id, expected.z.x + 0.05 * z_range, bearing_rad);
            (expected.z.x < 2.5).then_some(reading)
        };
        self.landmarks.iter().filter_map(of).collect()
    }
}

/// A filter of landmarks.
pub(crate) trait Seeing {
    fn drive(&mut self, counts: EncoderCounts);
    fn look(&mut self, readings: &[LandmarkReading]);
    fn answer(&self) -> (SE2, nalgebra::Matrix3<f64>);
}

macro_rules! seeing {
    ($($filter:ty),*) => { $(
        impl Seeing for $filter {
            fn drive(&mut self, counts: EncoderCounts) {
                self.advance(counts);
            }

            fn look(&mut self, readings: &[LandmarkReading]) {
                self.see(readings);
            }

            fn answer(&self) -> (SE2, nalgebra::Matrix3<f64>) {
                self.pose()
            }
        }
    )* };
}

seeing!(
    crate::eif_landmarks::EifLandmarks,
    crate::ekf_landmarks::EkfLandmarks,
    crate::ekf_slam::EkfSlam,
    crate::fastslam::FastSlam
);

/// Drives `ticks` ticks with a reading in every fifth. Returns the rms of the position error
/// in m, and the mean NEES of three numbers, over the ticks with a reading.
pub(crate) fn follow(filter: &mut impl Seeing, robot: &mut Robot, ticks: usize) -> (f64, f64) {
    let (mut squares_m2, mut nees, mut looks) = (0.0, 0.0, 0.0);
    for tick in 0..ticks {
        filter.drive(robot.drive());
        if tick % 5 == 0 {
            filter.look(&robot.look());
            let (pose, covariance) = filter.answer();
            let tau = robot.pose.boxminus(&pose);
            squares_m2 += tau.x * tau.x + tau.y * tau.y;
            nees += tau.dot(&(covariance.try_inverse().unwrap() * tau));
            looks += 1.0;
        }
    }
    ((squares_m2 / looks).sqrt(), nees / looks)
}
