//! The layout of an observation: which numbers of a frame are in its row, and where.
//!
//! A row holds the newest reading of each sensor as float32. A sensor that has no
//! reading in a tick keeps its numbers.
//!
//! | order | part           | numbers | unit, frame, meaning                                      |
//! |------:|----------------|--------:|-----------------------------------------------------------|
//! |     0 | `wheel_counts` |       2 | encoder counts of this tick, left and right               |
//! |     1 | `command`      |       2 | applied command v m/s, ω rad/s, body frame                |
//! |     2 | `scan_is_new`  |       1 | 1 in a tick with a scan, otherwise 0                      |
//! |     3 | `ranges_m`     |   beams | range of each beam, m, sensor frame                       |
//! |     4 | `bumper`       | sectors | 1 for each sector that touches, otherwise 0               |
//! |     5 | `imu`          |       3 | yaw rate rad/s, acceleration x and y m/s², body frame     |
//! |     6 | `sonars_m`     |  sonars | range of each sonar, m                                    |
//! |     7 | `doors`        |   doors | 1 for each door that is detected, by its number           |
//! |     8 | `landmarks`    |   3 × n | id (−1: not known, or no landmark), range m, bearing rad, body frame |
//!
//! Parts of sensors that the robot does not have are not there.

use rusty_contract::readings::MAX_LANDMARKS;
use rusty_contract::{Frame, RunConfig};
use rusty_geometry::{EncoderCounts, Material};

/// A row of `landmarks` without a landmark: id, range, bearing.
const NO_LANDMARK: [f64; 3] = [-1.0, 0.0, 0.0];

/// Where the numbers of a part come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    WheelCounts,
    Command,
    ScanIsNew,
    Ranges,
    Bumper,
    Imu,
    Sonars,
    Doors,
    Landmarks,
}

/// A part of an observation.
#[derive(Clone, Debug)]
pub struct Part {
    kind: Kind,
    /// Name, with its unit.
    pub name: &'static str,
    /// Length of each axis.
    pub shape: Vec<usize>,
    /// Least and greatest number that it can have.
    pub bounds: [f64; 2],
}

impl Part {
    /// The number of its numbers.
    fn width(&self) -> usize {
        self.shape.iter().product()
    }
}

/// The parts of the observations of one configuration, in the order of the table.
#[derive(Clone, Debug)]
pub struct Layout {
    parts: Vec<Part>,
}

impl Layout {
    /// The parts that a robot of this configuration has.
    pub fn of(config: &RunConfig) -> Self {
        let (unbounded, flag) = ([f64::NEG_INFINITY, f64::INFINITY], [0.0, 1.0]);
        let turned = config.robot.wheel_limit_rad_s * config.dt_s / std::f64::consts::TAU;
        // Counts are rounded at both ends of the tick.
        let counts = turned * config.robot.ticks_per_rev as f64 + 1.0;
        let [v_m_s, omega_rad_s] = command_limits(config);
        let fastest = v_m_s.max(omega_rad_s);
        let mut parts = Vec::new();
        let mut add = |kind, name, shape: &[usize], bounds| {
            parts.push(Part { kind, name, shape: shape.to_vec(), bounds });
        };
        add(Kind::WheelCounts, "wheel_counts", &[2], [-counts, counts]);
        add(Kind::Command, "command", &[2], [-fastest, fastest]);
        if config.scan_every > 0 {
            let lidar = &config.lidar;
            add(Kind::ScanIsNew, "scan_is_new", &[1], flag);
            add(Kind::Ranges, "ranges_m", &[lidar.beams as usize], [0.0, lidar.range_max_m]);
        }
        let sensors = &config.sensors;
        if let Some(bumper) = &sensors.bumper {
            add(Kind::Bumper, "bumper", &[bumper.sectors as usize], flag);
        }
        if sensors.imu.is_some() {
            add(Kind::Imu, "imu", &[3], unbounded);
        }
        if let Some(sonar) = &sensors.sonar {
            add(Kind::Sonars, "sonars_m", &[sonar.mounts.len()], [0.0, sonar.range_max_m]);
        }
        if sensors.doors.is_some() {
            let numbers = config.world.walls.iter().filter_map(|wall| match wall.material {
                Material::Door(number) => Some(usize::from(number) + 1),
                _ => None,
            });
            add(Kind::Doors, "doors", &[numbers.max().unwrap_or(0)], flag);
        }
        if sensors.landmarks.is_some() {
            let most = config.world.landmarks.len().min(MAX_LANDMARKS);
            add(Kind::Landmarks, "landmarks", &[most, 3], unbounded);
        }
        Self { parts }
    }

    /// The parts, in the order of the row.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Returns the row before the first tick: no range is known, and nothing is seen.
    pub fn first_row(&self) -> Vec<f32> {
        let numbers = self.parts.iter().flat_map(|part| {
            let numbers = match part.kind {
                Kind::Ranges | Kind::Sonars => [part.bounds[1]; 3],
                Kind::Landmarks => NO_LANDMARK,
                _ => [0.0; 3],
            };
            numbers.into_iter().cycle().take(part.width())
        });
        numbers.map(|number| number as f32).collect()
    }

    /// Writes what `frame` shows over the row of the tick before, whose encoder counts
    /// were `before`.
    pub fn write(&self, frame: &Frame, before: EncoderCounts, mut row: &mut [f32]) {
        let (readings, now, command) = (frame.readings(), frame.encoders(), frame.command());
        for part in &self.parts {
            let (places, behind) = row.split_at_mut(part.width());
            row = behind;
            match part.kind {
                Kind::WheelCounts => {
                    let turned = [now.left - before.left, now.right - before.right];
                    put(places, turned.map(|counts| counts as f64));
                }
                Kind::Command => put(places, [command.v_m_s, command.omega_rad_s]),
                Kind::ScanIsNew => put(places, [flag(frame.ranges_m().is_some())]),
                Kind::Ranges => keep_or_put(places, frame.ranges_m()),
                Kind::Sonars => keep_or_put(places, readings.sonar_ranges_m()),
                Kind::Imu => {
                    let imu = readings.imu();
                    let numbers = imu.map(|r| [r.yaw_rate_rad_s, r.accel_x_m_s2, r.accel_y_m_s2]);
                    keep_or_put(places, numbers.as_ref().map(<[f64; 3]>::as_slice));
                }
                Kind::Bumper => {
                    if let Some(bits) = readings.bumper() {
                        put(places, (0..16).map(|k| flag(bits >> k & 1 == 1)));
                    }
                }
                Kind::Doors => {
                    if let Some(seen) = readings.doors() {
                        put(places, (0_u8..).map(|number| flag(seen.contains(&number.into()))));
                    }
                }
                Kind::Landmarks => {
                    if let Some(seen) = readings.landmarks() {
                        let seen = seen.iter().flat_map(|one| {
                            let id = one.id().map_or(NO_LANDMARK[0], f64::from);
                            [id, one.range_m, one.bearing_rad]
                        });
                        put(places, seen.chain(NO_LANDMARK.into_iter().cycle()));
                    }
                }
            }
        }
    }
}

/// Writes numbers from the first place on, as many as there are places for.
fn put(places: &mut [f32], numbers: impl IntoIterator<Item = f64>) {
    places.iter_mut().zip(numbers).for_each(|(place, number)| *place = number as f32);
}

/// Writes a reading, where there is one.
fn keep_or_put(places: &mut [f32], numbers: Option<&[f64]>) {
    numbers.into_iter().for_each(|numbers| put(places, numbers.iter().copied()));
}

fn flag(is_set: bool) -> f64 {
    f64::from(u8::from(is_set))
}

/// Greatest `[v_m_s, omega_rad_s]` of a command that the wheels can follow, each alone.
pub fn command_limits(config: &RunConfig) -> [f64; 2] {
    let robot = &config.robot;
    let v_m_s = robot.wheel_limit_rad_s * robot.wheel_radius_m;
    [v_m_s, 2.0 * v_m_s / robot.track_m]
}
