//! The types of ROS 2, field by field as their definitions have them.
//!
//! Source: `common_interfaces` of the distribution Kilted. Against Humble, `Range` has
//! the field `variance` at its end, which a reader of Humble does not read; all else is
//! the same.

mod geometry;
mod nav;
mod sensor;
mod standard;
mod visualization;

pub use geometry::{
    Point, Pose, PoseStamped, PoseWithCovariance, PoseWithCovarianceStamped, Quaternion, TfMessage,
    Transform, TransformStamped, Twist, TwistStamped, TwistWithCovariance, Vector3,
};
pub use nav::{MapMetaData, OccupancyGrid, Odometry};
pub use sensor::{CompressedImage, FLOAT32, Imu, LaserScan, PointCloud2, PointField, Range};
pub use standard::{Clock, ColorRgba, Duration, Header, Text, Time};
pub use visualization::{Marker, MarkerArray, MeshFile, UvCoordinate};

#[cfg(test)]
mod tests;
