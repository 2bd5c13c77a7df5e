//! `geometry_msgs` and `tf2_msgs`, and poses of the plane in them.

use rusty_geometry::{SE2, trig};
use serde::{Deserialize, Serialize};
use serde_big_array::BigArray;

use super::standard::{Header, Text};
use crate::cdr::RosMessage;

/// A point, m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Ahead or east, m.
    pub x: f64,
    /// To the left or north, m.
    pub y: f64,
    /// Up, m.
    pub z: f64,
}

/// A vector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector3 {
    /// Part along x.
    pub x: f64,
    /// Part along y.
    pub y: f64,
    /// Part along z.
    pub z: f64,
}

/// A rotation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    /// Part along x.
    pub x: f64,
    /// Part along y.
    pub y: f64,
    /// Part along z.
    pub z: f64,
    /// Real part.
    pub w: f64,
}

impl Default for Quaternion {
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}

impl Quaternion {
    /// Returns the rotation about z.
    #[must_use]
    pub fn from_yaw(yaw_rad: f64) -> Self {
        let (z, w) = trig::sin_cos(0.5 * yaw_rad);
        Self { x: 0.0, y: 0.0, z, w }
    }

    /// Returns the angle about z, rad: the yaw of roll, pitch and yaw.
    #[must_use]
    pub fn yaw_rad(&self) -> f64 {
        let Self { x, y, z, w } = *self;
        trig::atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
    }
}

/// A pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Where it is.
    pub position: Point,
    /// Where it looks.
    pub orientation: Quaternion,
}

impl From<SE2> for Pose {
    fn from(pose: SE2) -> Self {
        let position = Point { x: pose.x(), y: pose.y(), z: 0.0 };
        Self { position, orientation: Quaternion::from_yaw(pose.theta()) }
    }
}

impl From<Pose> for SE2 {
    /// Drops height, roll and pitch.
    fn from(pose: Pose) -> Self {
        Self::new(pose.position.x, pose.position.y, pose.orientation.yaw_rad())
    }
}

/// A pose with its time and frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseStamped {
    /// Time and frame.
    pub header: Header,
    /// The pose.
    pub pose: Pose,
}

/// A pose with its covariance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseWithCovariance {
    /// The pose.
    pub pose: Pose,
    /// Row-major 6×6 over x, y, z and the rotations about x, y, z; zeros: not known.
    #[serde(with = "BigArray")]
    pub covariance: [f64; 36],
}

/// A pose with covariance, time and frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseWithCovarianceStamped {
    /// Time and frame.
    pub header: Header,
    /// The pose.
    pub pose: PoseWithCovariance,
}

/// A velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// m/s.
    pub linear: Vector3,
    /// rad/s.
    pub angular: Vector3,
}

impl From<rusty_geometry::Twist> for Twist {
    fn from(twist: rusty_geometry::Twist) -> Self {
        let linear = Vector3 { x: twist.v_m_s, ..Vector3::default() };
        Self { linear, angular: Vector3 { z: twist.omega_rad_s, ..Vector3::default() } }
    }
}

/// A velocity with its time and frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TwistStamped {
    /// Time and frame.
    pub header: Header,
    /// The velocity.
    pub twist: Twist,
}

/// A velocity with its covariance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TwistWithCovariance {
    /// The velocity.
    pub twist: Twist,
    /// As that of [`PoseWithCovariance`].
    #[serde(with = "BigArray")]
    pub covariance: [f64; 36],
}

/// The pose of one frame in another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Transform {
    /// Where the origin is, m.
    pub translation: Vector3,
    /// Where it looks.
    pub rotation: Quaternion,
}

impl From<SE2> for Transform {
    fn from(pose: SE2) -> Self {
        let translation = Vector3 { x: pose.x(), y: pose.y(), z: 0.0 };
        Self { translation, rotation: Quaternion::from_yaw(pose.theta()) }
    }
}

impl From<Transform> for SE2 {
    /// Drops height, roll and pitch.
    fn from(transform: Transform) -> Self {
        let Vector3 { x, y, .. } = transform.translation;
        Self::new(x, y, transform.rotation.yaw_rad())
    }
}

/// The pose of the frame `child_frame_id` in that of the header.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TransformStamped {
    /// Time and frame.
    pub header: Header,
    /// The frame whose pose it is.
    pub child_frame_id: Text,
    /// The pose.
    pub transform: Transform,
}

/// Poses of frames.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TfMessage {
    /// The poses.
    pub transforms: Vec<TransformStamped>,
}

impl RosMessage for PoseStamped {
    const NAME: &'static str = "geometry_msgs/msg/PoseStamped";
}
impl RosMessage for PoseWithCovarianceStamped {
    const NAME: &'static str = "geometry_msgs/msg/PoseWithCovarianceStamped";
}
impl RosMessage for Twist {
    const NAME: &'static str = "geometry_msgs/msg/Twist";
}
impl RosMessage for TwistStamped {
    const NAME: &'static str = "geometry_msgs/msg/TwistStamped";
}
impl RosMessage for TfMessage {
    const NAME: &'static str = "tf2_msgs/msg/TFMessage";
}
