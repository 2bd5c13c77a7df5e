//! A tick in, messages out.

use nalgebra::Matrix3;
use rusty_contract::{Estimate, ImuReading, Readings};
use rusty_geometry::{EncoderCounts, SE2, Twist, odometry_delta, trig};

use crate::cdr::{CdrError, RosMessage};
use crate::channel::{Channel, Content, channels};
use crate::description::Description;
use crate::latched::{
    BASE, IMU, LASER, MAP, ODOM, header, map, markers, sonar_frame, static_frames, transform,
};
use crate::messages::{
    Clock, FLOAT32, Imu, LaserScan, Odometry, PointCloud2, PointField, PoseStamped,
    PoseWithCovariance, PoseWithCovarianceStamped, Quaternion, Range, Text, TfMessage, Time,
    TwistStamped, TwistWithCovariance, Vector3,
};

/// Bytes of a point: x, y and z as `f32`.
const POINT_BYTES: usize = 12;
/// Acceleration of a body that gravity does not move, m/s² (REP 145).
const GRAVITY_M_S2: f64 = 9.80665;

/// What happened in a tick.
#[derive(Clone, Copy, Debug)]
pub struct Tick<'a> {
    /// Time of the frame, s.
    pub time_s: f64,
    /// Cumulative encoder counts.
    pub counts: EncoderCounts,
    /// Command applied in this tick, body frame.
    pub command: Twist,
    /// The scan, where there is one, m.
    pub ranges_m: Option<&'a [f64]>,
    /// Readings of the small sensors.
    pub readings: Readings<'a>,
    /// True pose, world frame, where it is known and may be sent.
    pub truth: Option<SE2>,
    /// Estimates in effect, in the order of [`Description::estimators`].
    pub estimates: &'a [Option<Estimate>],
}

/// A message in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Encoded<'a> {
    /// Index of its channel in [`Encoder::channels`].
    pub channel: usize,
    /// Time at which it is recorded: that of its tick, ns; 0 for a time before zero.
    pub time_ns: u64,
    /// The bytes.
    pub cdr: &'a [u8],
}

/// The messages of a tick, one after the other.
#[derive(Debug)]
struct Batch {
    channels: Vec<Channel>,
    is_selected: Vec<bool>,
    bytes: Vec<u8>,
    /// Channel of each message, and where its bytes end.
    ends: Vec<(usize, usize)>,
}

impl Batch {
    /// Adds a message, if its topic exists and is selected.
    fn put(&mut self, content: Content, message: &impl RosMessage) -> Result<(), CdrError> {
        let Some(channel) = self.wanted(content) else { return Ok(()) };
        message.append_cdr(&mut self.bytes)?;
        self.ends.push((channel, self.bytes.len()));
        Ok(())
    }

    fn wanted(&self, content: Content) -> Option<usize> {
        let channel = self.channels.iter().position(|channel| channel.content == content)?;
        self.is_selected[channel].then_some(channel)
    }

    fn clear(&mut self) {
        self.bytes.clear();
        self.ends.clear();
    }

    fn messages(&self, time_ns: u64) -> impl ExactSizeIterator<Item = Encoded<'_>> + use<'_> {
        self.ends.iter().enumerate().map(move |(k, &(channel, end))| {
            let start = k.checked_sub(1).map_or(0, |before| self.ends[before].1);
            Encoded { channel, time_ns, cdr: &self.bytes[start..end] }
        })
    }
}

/// Turns the ticks of a run, in their order from the first one, into messages.
#[derive(Debug)]
pub struct Encoder {
    about: Description,
    batch: Batch,
    scan: LaserScan,
    points: PointCloud2,
    /// Cosine and sine of each beam's bearing.
    directions: Vec<[f64; 2]>,
    sonar_frames: Vec<String>,
    /// Pose by dead reckoning, frame `odom`.
    odometry: SE2,
    counts: EncoderCounts,
    last_s: Option<f64>,
    /// Mean velocity since the tick before, by the counts.
    twist: Twist,
    /// Pose of `odom` in `map`, as far as it is known.
    odom_in_map: Option<SE2>,
}

impl Encoder {
    /// Returns an encoder before the first tick. All channels are selected.
    #[must_use]
    pub fn new(about: Description) -> Self {
        let channels = channels(&about);
        let is_selected = vec![true; channels.len()];
        let fan = about.lidar.fan();
        let direction = |k| {
            let (sin, cos) = trig::sin_cos(fan.bearing_rad(k));
            [cos, sin]
        };
        let sonars = about.sensors.sonar.as_ref().map_or(0, |sonar| sonar.mounts.len());
        Self {
            batch: Batch { channels, is_selected, bytes: Vec::new(), ends: Vec::new() },
            scan: scan(&about),
            points: points(),
            directions: (0..fan.beams).map(direction).collect(),
            sonar_frames: (0..sonars).map(sonar_frame).collect(),
            odometry: SE2::identity(),
            counts: EncoderCounts::default(),
            last_s: None,
            twist: Twist::default(),
            odom_in_map: about.localizer.and(about.start),
            about,
        }
    }

    /// The topics.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        &self.batch.channels
    }

    /// Selects the channels that are encoded from now on.
    pub fn select(&mut self, is_wanted: impl Fn(&Channel) -> bool) {
        self.batch.is_selected = self.batch.channels.iter().map(is_wanted).collect();
    }

    /// Returns the messages of the latched channels, for a subscriber that comes later.
    ///
    /// # Errors
    /// [`CdrError`].
    pub fn latched(
        &mut self,
        time_s: f64,
    ) -> Result<impl ExactSizeIterator<Item = Encoded<'_>>, CdrError> {
        let time_ns = nanoseconds(time_s);
        self.batch.clear();
        self.put_latched(Time::from_ns(time_ns))?;
        Ok(self.batch.messages(time_ns))
    }

    /// Returns the messages of the next tick, those of the latched channels first in the
    /// first tick.
    ///
    /// # Errors
    /// [`CdrError`].
    pub fn tick<'s>(
        &'s mut self,
        tick: &Tick<'_>,
    ) -> Result<impl ExactSizeIterator<Item = Encoded<'s>> + use<'s>, CdrError> {
        let stamp = Time::from_ns(nanoseconds(tick.time_s));
        self.batch.clear();
        self.batch.put(Content::Clock, &Clock { clock: stamp })?;
        if self.last_s.is_none() {
            self.put_latched(stamp)?;
        }
        self.advance(tick.time_s, tick.counts);
        self.put_tick(stamp, tick)?;
        Ok(self.batch.messages(nanoseconds(tick.time_s)))
    }

    /// Returns the messages of the tick that was taken last, latched ones left out.
    ///
    /// # Errors
    /// [`CdrError`].
    pub fn messages(
        &mut self,
        tick: &Tick<'_>,
    ) -> Result<impl ExactSizeIterator<Item = Encoded<'_>>, CdrError> {
        let stamp = Time::from_ns(nanoseconds(tick.time_s));
        self.batch.clear();
        self.batch.put(Content::Clock, &Clock { clock: stamp })?;
        self.put_tick(stamp, tick)?;
        Ok(self.batch.messages(nanoseconds(tick.time_s)))
    }

    /// Takes the next tick without its messages: moves the dead reckoning on.
    pub fn advance(&mut self, time_s: f64, counts: EncoderCounts) {
        let delta = odometry_delta(self.counts, counts, &self.about.drive);
        self.counts = counts;
        self.odometry = self.odometry.boxplus(&delta);
        let passed_s = self.last_s.replace(time_s).map_or(0.0, |last_s| time_s - last_s);
        let passed_s = if passed_s > 0.0 { passed_s } else { self.about.dt_s };
        self.twist = Twist { v_m_s: delta.x / passed_s, omega_rad_s: delta.z / passed_s };
    }

    fn put_tick(&mut self, stamp: Time, tick: &Tick<'_>) -> Result<(), CdrError> {
        self.put_frames(stamp, tick)?;
        self.put_odometry(stamp)?;
        let twist = tick.command.into();
        self.batch.put(Content::Command, &TwistStamped { header: header(stamp, BASE), twist })?;
        if let Some(ranges_m) = tick.ranges_m {
            self.put_scan(stamp, ranges_m)?;
        }
        self.put_readings(stamp, &tick.readings)?;
        for (k, estimate) in tick.estimates.iter().enumerate() {
            if let Some(estimate) = estimate {
                let pose = with_covariance(estimate);
                let message = PoseWithCovarianceStamped { header: header(stamp, MAP), pose };
                self.batch.put(Content::Pose(k), &message)?;
            }
        }
        if let Some(truth) = tick.truth {
            let message = PoseStamped { header: header(stamp, MAP), pose: truth.into() };
            self.batch.put(Content::Truth, &message)?;
        }
        Ok(())
    }

    fn put_latched(&mut self, stamp: Time) -> Result<(), CdrError> {
        self.batch.put(Content::StaticFrames, &static_frames(&self.about, stamp))?;
        if let Some(world) = &self.about.world {
            if self.batch.wanted(Content::Map).is_some() {
                self.batch.put(Content::Map, &map(world, stamp))?;
            }
            self.batch.put(Content::Markers, &markers(world, stamp))?;
        }
        Ok(())
    }

    fn put_frames(&mut self, stamp: Time, tick: &Tick<'_>) -> Result<(), CdrError> {
        let localizer = self.about.localizer.and_then(|k| *tick.estimates.get(k)?);
        if let Some(estimate) = localizer {
            self.odom_in_map = Some(estimate.pose_in_world * self.odometry.inverse());
        }
        let mut transforms = vec![transform(stamp, ODOM, BASE, self.odometry)];
        transforms.extend(self.odom_in_map.map(|pose| transform(stamp, MAP, ODOM, pose)));
        self.batch.put(Content::Frames, &TfMessage { transforms })
    }

    fn put_odometry(&mut self, stamp: Time) -> Result<(), CdrError> {
        let message = Odometry {
            header: header(stamp, ODOM),
            child_frame_id: Text::Borrowed(BASE),
            pose: PoseWithCovariance { pose: self.odometry.into(), covariance: [0.0; 36] },
            twist: TwistWithCovariance { twist: self.twist.into(), covariance: [0.0; 36] },
        };
        self.batch.put(Content::Odometry, &message)
    }

    fn put_scan(&mut self, stamp: Time, ranges_m: &[f64]) -> Result<(), CdrError> {
        let max_m = self.about.lidar.range_max_m;
        self.scan.header.stamp = stamp;
        self.scan.ranges.clear();
        self.scan.ranges.extend(ranges_m.iter().map(|range_m| range(*range_m, max_m)));
        self.batch.put(Content::Scan, &self.scan)?;
        self.points.header.stamp = stamp;
        self.points.data.clear();
        for (range_m, [cos, sin]) in ranges_m.iter().zip(&self.directions) {
            if *range_m < max_m {
                let xyz = [range_m * cos, range_m * sin, 0.0].map(|m| (m as f32).to_le_bytes());
                self.points.data.extend(xyz.as_flattened());
            }
        }
        self.points.width = (self.points.data.len() / POINT_BYTES) as u32;
        self.points.row_step = self.points.data.len() as u32;
        self.batch.put(Content::ScanPoints, &self.points)
    }

    fn put_readings(&mut self, stamp: Time, readings: &Readings<'_>) -> Result<(), CdrError> {
        if let Some(reading) = readings.imu() {
            self.batch.put(Content::Imu, &imu(stamp, &reading))?;
        }
        let (Some(sonar), Some(ranges_m)) = (&self.about.sensors.sonar, readings.sonar_ranges_m())
        else {
            return Ok(());
        };
        for (k, (range_m, frame)) in ranges_m.iter().zip(&self.sonar_frames).enumerate() {
            let std_m = sonar.range_std_m.unwrap_or(0.0);
            let mut message = Range {
                field_of_view: sonar.aperture_rad as f32,
                max_range: sonar.range_max_m as f32,
                range: range(*range_m, sonar.range_max_m),
                variance: (std_m * std_m) as f32,
                ..Range::default()
            };
            (message.header.stamp, message.header.frame_id) = (stamp, frame.clone().into());
            self.batch.put(Content::Sonar(k), &message)?;
        }
        Ok(())
    }
}

/// Returns a time in nanoseconds, the nearest whole number.
fn nanoseconds(time_s: f64) -> u64 {
    (time_s * 1e9).round() as u64
}

/// Returns a range as REP 117 has it: +∞ where nothing came back.
fn range(range_m: f64, max_m: f64) -> f32 {
    if range_m < max_m { range_m as f32 } else { f32::INFINITY }
}

/// Returns a scan without ranges.
fn scan(about: &Description) -> LaserScan {
    let lidar = &about.lidar;
    let last = lidar.beams.saturating_sub(1);
    LaserScan {
        header: header(Time::default(), LASER),
        angle_min: lidar.first_bearing_rad as f32,
        angle_max: lidar.bearing_rad(last) as f32,
        angle_increment: (lidar.fov_rad / f64::from(lidar.beams)) as f32,
        scan_time: (about.scan_every as f64 * about.dt_s) as f32,
        range_max: lidar.range_max_m as f32,
        ..LaserScan::default()
    }
}

/// Returns a cloud without points.
fn points() -> PointCloud2 {
    let field = |(k, name): (u32, &'static str)| PointField {
        name: Text::Borrowed(name),
        offset: 4 * k,
        datatype: FLOAT32,
        count: 1,
    };
    PointCloud2 {
        header: header(Time::default(), LASER),
        height: 1,
        fields: (0..).zip(["x", "y", "z"]).map(field).collect(),
        point_step: POINT_BYTES as u32,
        is_dense: true,
        ..PointCloud2::default()
    }
}

/// Returns a reading of the IMU. It has no orientation; the floor is level.
fn imu(stamp: Time, reading: &ImuReading) -> Imu {
    let mut orientation_covariance = [0.0; 9];
    orientation_covariance[0] = -1.0;
    Imu {
        header: header(stamp, IMU),
        orientation: Quaternion::default(),
        orientation_covariance,
        angular_velocity: Vector3 { x: 0.0, y: 0.0, z: reading.yaw_rate_rad_s },
        linear_acceleration: Vector3 {
            x: reading.accel_x_m_s2,
            y: reading.accel_y_m_s2,
            z: GRAVITY_M_S2,
        },
        ..Imu::default()
    }
}

/// Returns pose and covariance. The covariance of an estimate is in the body's frame,
/// that of ROS in the frame of the header; z, roll and pitch have zeros, as AMCL writes.
fn with_covariance(estimate: &Estimate) -> PoseWithCovariance {
    let mut covariance = [0.0; 36];
    if let Some(body) = &estimate.covariance {
        let (sin, cos) = trig::sin_cos(estimate.pose_in_world.theta());
        let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let turned = turn * Matrix3::from_row_slice(body) * turn.transpose();
        for (i, row) in [0, 1, 5].into_iter().enumerate() {
            for (j, column) in [0, 1, 5].into_iter().enumerate() {
                covariance[6 * row + column] = turned[(i, j)];
            }
        }
    }
    PoseWithCovariance { pose: estimate.pose_in_world.into(), covariance }
}

#[cfg(test)]
mod tests;
