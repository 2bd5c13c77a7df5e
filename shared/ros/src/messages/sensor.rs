//! `sensor_msgs`.

use serde::{Deserialize, Serialize};

use super::geometry::{Quaternion, Vector3};
use super::standard::{Header, Text};
use crate::cdr::RosMessage;

/// [`PointField::datatype`] of an `f32`.
pub const FLOAT32: u8 = 7;

/// A scan of a planar LiDAR. Beam k points along `angle_min` + k · `angle_increment`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LaserScan {
    /// Time of the first beam, and the frame of the sensor.
    pub header: Header,
    /// Bearing of the first beam, rad.
    pub angle_min: f32,
    /// Bearing of the last beam, rad.
    pub angle_max: f32,
    /// Angle from beam to beam, rad.
    pub angle_increment: f32,
    /// Time from beam to beam, s.
    pub time_increment: f32,
    /// Time from scan to scan, s; 0: not known.
    pub scan_time: f32,
    /// Least range, m.
    pub range_min: f32,
    /// Greatest range, m.
    pub range_max: f32,
    /// Ranges, m; +∞: no return.
    pub ranges: Vec<f32>,
    /// Intensities; may be empty.
    pub intensities: Vec<f32>,
}

/// One number of each point of a cloud.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PointField {
    /// Name, such as `x`.
    pub name: Text,
    /// First byte within a point.
    pub offset: u32,
    /// Kind of number.
    pub datatype: u8,
    /// How many of them.
    pub count: u32,
}

/// A cloud of points.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PointCloud2 {
    /// Time and frame.
    pub header: Header,
    /// Number of rows; 1: points without an order.
    pub height: u32,
    /// Points in a row.
    pub width: u32,
    /// Numbers of a point.
    pub fields: Vec<PointField>,
    /// Byte order of the numbers.
    pub is_bigendian: bool,
    /// Bytes of a point.
    pub point_step: u32,
    /// Bytes of a row.
    pub row_step: u32,
    /// The points.
    pub data: Vec<u8>,
    /// All points are valid.
    pub is_dense: bool,
}

/// A reading of an inertial measurement unit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Imu {
    /// Time, and the frame of the sensor.
    pub header: Header,
    /// Orientation, where it is measured.
    pub orientation: Quaternion,
    /// Row-major 3×3, rad²; −1 in the first: no orientation is measured.
    pub orientation_covariance: [f64; 9],
    /// rad/s.
    pub angular_velocity: Vector3,
    /// Row-major 3×3; zeros: not known.
    pub angular_velocity_covariance: [f64; 9],
    /// m/s², the reaction to gravity included.
    pub linear_acceleration: Vector3,
    /// Row-major 3×3; zeros: not known.
    pub linear_acceleration_covariance: [f64; 9],
}

/// A reading of a sonar.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// Time, and the frame of the sensor.
    pub header: Header,
    /// 0: ultrasound, 1: infrared.
    pub radiation_type: u8,
    /// Full angle of the cone, rad.
    pub field_of_view: f32,
    /// Least range, m.
    pub min_range: f32,
    /// Greatest range, m.
    pub max_range: f32,
    /// The range, m; +∞: no return.
    pub range: f32,
    /// Variance of the range, m²; 0: not known.
    pub variance: f32,
}

/// A compressed picture; here always an empty one, as part of a marker.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CompressedImage {
    /// Time and frame.
    pub header: Header,
    /// Name of the format.
    pub format: Text,
    /// The picture.
    pub data: Vec<u8>,
}

impl RosMessage for LaserScan {
    const NAME: &'static str = "sensor_msgs/msg/LaserScan";
}
impl RosMessage for PointCloud2 {
    const NAME: &'static str = "sensor_msgs/msg/PointCloud2";
}
impl RosMessage for Imu {
    const NAME: &'static str = "sensor_msgs/msg/Imu";
}
impl RosMessage for Range {
    const NAME: &'static str = "sensor_msgs/msg/Range";
}
