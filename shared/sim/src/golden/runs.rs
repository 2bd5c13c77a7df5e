//! The configurations of the golden runs.
//!
//! Every number is written out, none is left to a default: a default may change
//! with the taste of its time, a golden run may not.

use std::f64::consts::{PI, TAU};

use rusty_contract::config::sensors::{
    BumperConfig, DoorSensorConfig, Identity, ImuConfig, LandmarkSensorConfig, SonarConfig,
    SonarModel,
};
use rusty_contract::config::{PatchConfig, PatrolConfig};
use rusty_contract::{LidarConfig, RobotConfig, RunConfig, ScriptConfig, Sensors};
use rusty_geometry::{
    Landmark, Material, SE2, Twist, WallSpec, World, WorldSpec, apartment, hallway, lobby, open,
    place, trig, wrap_angle,
};

/// Rusty in a place; for each run to change.
fn rusty(name: &str, world: &World, start: SE2, script: ScriptConfig) -> RunConfig {
    RunConfig {
        scenario: format!("golden-{name}"),
        seed: 42,
        ticks: 300,
        dt_s: 0.02,
        scan_every: 5,
        start,
        robot: RobotConfig {
            wheel_radius_m: 0.033,
            track_m: 0.16,
            body_radius_m: 0.11,
            ticks_per_rev: 4096,
            wheel_limit_rad_s: 20.0,
            slip_std: 0.02,
            slip_std_left: None,
            slip_std_right: None,
            slip_outlier_rate: 0.0,
            slip_outlier_factor: 10.0,
            radius_bias_right: 0.0,
            track_bias: 0.0,
        },
        lidar: LidarConfig {
            beams: 180,
            first_bearing_rad: -PI,
            fov_rad: TAU,
            range_max_m: 8.0,
            range_std_m: 0.02,
            range_std_per_m: 0.0,
            dropout: 0.0,
            glass_visible_rad: 0.5 * PI,
            divergence_rad: 0.0,
            sensor_in_body: SE2::identity(),
        },
        script,
        world: world.spec().clone(),
        sensors: Sensors::default(),
        kidnappings: Vec::new(),
        walkers: Vec::new(),
        crowd: None,
        events: Vec::new(),
        fleet: None,
        patches: Vec::new(),
    }
}

/// Up and down on a timetable short enough to turn within a golden run.
fn patrol() -> PatrolConfig {
    PatrolConfig {
        v_m_s: 0.57,
        omega_rad_s: -3.1363,
        ramp_s: 0.6,
        first_s: 2.3,
        leg_s: 4.1,
        pause_s: 0.3,
        turn_s: 1.0,
    }
}

pub(super) fn apartment_steered() -> RunConfig {
    let script = ScriptConfig::TruthSteeredPatrol(patrol());
    let start = SE2::new(6.0, 4.5, 0.0);
    RunConfig { ticks: 400, ..rusty("apartment-steered", &apartment(), start, script) }
}

pub(super) fn hallway_patrol() -> RunConfig {
    let script = ScriptConfig::Patrol(patrol());
    let start = SE2::new(3.3, 0.81, 0.07);
    let mut run = rusty("hallway-patrol", &hallway(), start, script);
    (run.seed, run.ticks, run.dt_s, run.scan_every) = (7, 150, 0.1, 3);
    run.lidar.dropout = 0.2;
    run
}

pub(super) fn open_eight() -> RunConfig {
    let script = ScriptConfig::FigureEight { v_m_s: 0.5, omega_rad_s: 0.6, half_s: 1.7 };
    let start = SE2::new(-711.3, 402.9, -3.1);
    let mut run = rusty("open-eight", &open(), start, script);
    (run.seed, run.scan_every) = (u64::MAX, 0);
    run.robot.slip_std = 0.05;
    run.robot.radius_bias_right = 0.01;
    run
}

pub(super) fn apartment_blocked() -> RunConfig {
    let script = ScriptConfig::Straight { v_m_s: 2.0 };
    // The wall x = 12 of the living room is 0.7 m ahead, a little aslant.
    let start = SE2::new(11.3, 3.0, 0.21);
    let mut run = rusty("apartment-blocked", &apartment(), start, script);
    (run.seed, run.ticks, run.scan_every) = (3, 60, 1);
    run
}

pub(super) fn hallway_commands() -> RunConfig {
    let turn = |i: u32| Twist { v_m_s: 0.03 * f64::from(i % 11), omega_rad_s: 0.9 };
    let back = |i: u32| Twist { v_m_s: -0.2, omega_rad_s: -0.07 * f64::from(i) };
    let list = (0..40).map(turn).chain((0..30).map(back)).collect();
    let script = ScriptConfig::Commands { file: None, list };
    let start = SE2::new(7.9, 0.7, 2.0);
    let mut run = rusty("hallway-commands", &hallway(), start, script);
    (run.seed, run.ticks, run.dt_s, run.scan_every) = (1 << 63, 90, 0.05, 6);
    // Two metres: many ranges are cut off at zero and at the limit.
    run.lidar.range_std_m = 2.0;
    run.lidar.range_max_m = 3.0;
    run
}

pub(super) fn apartment_driven() -> RunConfig {
    let start = SE2::new(9.6, 3.0, 1.0);
    let mut run = rusty("apartment-driven", &apartment(), start, ScriptConfig::Driver {});
    (run.seed, run.ticks, run.scan_every) = (0, 200, 40);
    run.lidar.beams = 1080;
    run
}

pub(super) fn apartment_sensed() -> RunConfig {
    let script = ScriptConfig::Straight { v_m_s: 0.5 };
    // Towards door 0, with door 1 at the edge of the view; the wall stops the robot
    // after some 200 ticks.
    let start = SE2::new(2.2, 4.7, -2.98);
    let mut run = rusty("apartment-sensed", &apartment(), start, script);
    let posts = (0..24u32).map(|k| {
        let at = [0.4 + 0.5 * f64::from(k), 0.7 + f64::from(k * 7 % 24) * 0.3];
        Landmark { id: 100 + k, at }
    });
    run.world.landmarks = posts.collect();
    let mounts = (0..16u32).map(|k| {
        let bearing_rad = wrap_angle(TAU * f64::from(k) / 16.0);
        let (s, c) = trig::sin_cos(bearing_rad);
        SE2::new(0.11 * c, 0.11 * s, bearing_rad)
    });
    run.sensors = Sensors {
        bumper: Some(BumperConfig { sectors: 5, first_bearing_rad: -0.5 * PI, fov_rad: PI }),
        imu: Some(ImuConfig {
            gyro_noise_deg_sqrt_h: 0.3,
            gyro_bias_instability_deg_h: 4.6,
            gyro_turn_on_bias_deg_h: 30.0,
            accel_noise_ug_sqrt_hz: 400.0,
            accel_bias_instability_ug: 36.0,
            accel_turn_on_bias_ug: 1000.0,
            bias_time_s: 500.0,
        }),
        sonar: Some(SonarConfig {
            mounts: mounts.collect(),
            aperture_rad: 0.5,
            range_max_m: 5.0,
            range_std_m: 0.01,
            dropout: 0.1,
            model: SonarModel::Nearest,
            every: 3,
        }),
        doors: Some(DoorSensorConfig {
            range_max_m: 5.0,
            fov_rad: 4.4,
            hit_rate: 0.6,
            false_alarm_rate: 0.2,
            every: 2,
        }),
        landmarks: Some(LandmarkSensorConfig {
            range_max_m: 3.0,
            fov_rad: 5.0,
            range_std_m: 0.05,
            bearing_std_rad: 0.03,
            dropout: 0.1,
            identity: Identity::Given,
            every: 4,
        }),
    };
    run
}

pub(super) fn lobby_glass() -> RunConfig {
    let script = ScriptConfig::FigureEight { v_m_s: 0.5, omega_rad_s: 0.7, half_s: 2.1 };
    // Before the porch, whose panes are two or three in a row.
    let start = SE2::new(5.3, 2.2, -0.4);
    let mut run = rusty("lobby-glass", &lobby(), start, script);
    (run.seed, run.scan_every) = (11, 10);
    run.robot.slip_std = 0.01;
    run.lidar.range_max_m = 12.0;
    run.lidar.range_std_m = 0.01;
    run.lidar.range_std_per_m = 0.005;
    run.lidar.dropout = 0.02;
    run.lidar.glass_visible_rad = 0.26;
    run.lidar.divergence_rad = 0.02;
    run
}

/// A room without a right angle: four outer walls and a door, and a pane of
/// glass that stands free in it.
fn crooked_room() -> WorldSpec {
    let wall = |a: [f64; 2], b: [f64; 2], material| WallSpec { a, b, material };
    let corners =
        [[0.13, 0.07], [5.71, 0.42], [6.11, 2.03], [6.37, 3.89], [2.93, 5.23], [-0.61, 3.31]];
    let mut walls: Vec<WallSpec> = (0..corners.len())
        .map(|i| wall(corners[i], corners[(i + 1) % corners.len()], Material::Wall))
        .collect();
    walls[1].material = Material::Door(7);
    walls.push(wall([2.2, 1.9], [2.9, 2.77], Material::Glass));
    WorldSpec {
        name: "crooked-room".to_owned(),
        bounds: [-1.3, -0.4, 7.7, 6.1],
        walls,
        landmarks: Vec::new(),
    }
}

pub(super) fn lopsided() -> RunConfig {
    RunConfig {
        scenario: "golden-lopsided".to_owned(),
        seed: 0x5eed_0dd5,
        ticks: 240,
        dt_s: 0.033,
        scan_every: 7,
        start: SE2::new(0.31, 2.41, 2.3),
        robot: RobotConfig {
            wheel_radius_m: 0.0371,
            track_m: 0.193,
            body_radius_m: 0.127,
            ticks_per_rev: 1000,
            wheel_limit_rad_s: 11.3,
            slip_std: 0.031,
            slip_std_left: None,
            slip_std_right: None,
            slip_outlier_rate: 0.0,
            slip_outlier_factor: 10.0,
            radius_bias_right: -0.0137,
            track_bias: 0.0,
        },
        lidar: LidarConfig {
            beams: 97,
            first_bearing_rad: -1.9,
            fov_rad: 4.1,
            range_max_m: 3.7,
            range_std_m: 0.053,
            range_std_per_m: 0.0,
            dropout: 0.07,
            glass_visible_rad: 0.5 * PI,
            divergence_rad: 0.0,
            sensor_in_body: SE2::new(0.083, -0.029, 0.37),
        },
        script: ScriptConfig::Driver {},
        world: crooked_room(),
        sensors: Sensors::default(),
        kidnappings: Vec::new(),
        walkers: Vec::new(),
        crowd: None,
        events: Vec::new(),
        fleet: None,
        patches: Vec::new(),
    }
}

/// A triangle and a rectangle of floor that overlap.
fn floor() -> Vec<PatchConfig> {
    let patch = |corners, slip_std, slip_outlier_rate| PatchConfig {
        corners,
        slip_std,
        slip_outlier_rate,
        slip_outlier_factor: 6.5,
    };
    vec![
        patch(vec![[6.3, 4.1], [7.1, 4.1], [7.1, 4.9], [6.3, 4.9]], 0.0, 0.0),
        patch(vec![[6.1, 4.43], [6.9, 3.9], [6.95, 5.2]], 0.11, 0.2),
    ]
}

pub(super) fn apartment_slippery() -> RunConfig {
    let start = SE2::new(6.0, 4.5, 0.0);
    let script = ScriptConfig::Patrol(patrol());
    let mut run = rusty("apartment-slippery", &apartment(), start, script);
    run.robot.slip_std_left = Some(0.05);
    (run.robot.slip_outlier_rate, run.robot.slip_outlier_factor) = (0.07, 8.0);
    run.patches = floor();
    run
}

pub(super) fn apartment_silent() -> RunConfig {
    let script = ScriptConfig::FigureEight { v_m_s: 0.45, omega_rad_s: 0.8, half_s: 2.6 };
    let start = SE2::new(4.9, 2.84, 1.1);
    let mut run = rusty("apartment-silent", &apartment(), start, script);
    (run.dt_s, run.scan_every) = (0.05, 30);
    run.robot.slip_std = 0.0;
    run.lidar.range_std_m = 0.0;
    run
}

/// Two seconds in a place that is made by rule, with ten scans.
fn generated(name: &str, start: SE2) -> RunConfig {
    let script = ScriptConfig::FigureEight { v_m_s: 0.4, omega_rad_s: 0.7, half_s: 1.1 };
    let world = place(name).unwrap_or_else(open);
    RunConfig { ticks: 100, scan_every: 10, ..rusty(name, &world, start, script) }
}

pub(super) fn corridor() -> RunConfig {
    generated("corridor", SE2::new(18.0, 1.0, 0.1))
}

pub(super) fn twin_rooms() -> RunConfig {
    generated("twin-rooms", SE2::new(2.2, 2.4, 0.4))
}

pub(super) fn workshop() -> RunConfig {
    generated("workshop", SE2::new(6.0, 4.5, 0.0))
}

pub(super) fn warehouse() -> RunConfig {
    generated("warehouse", SE2::new(24.0, 30.9, -0.2))
}
