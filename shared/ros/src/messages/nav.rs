//! `nav_msgs`.

use serde::{Deserialize, Serialize};

use super::geometry::{Pose, PoseWithCovariance, TwistWithCovariance};
use super::standard::{Header, Text, Time};
use crate::cdr::RosMessage;

/// Pose and velocity of a robot by its odometry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Odometry {
    /// Time, and the frame of the pose.
    pub header: Header,
    /// Frame of the velocity: the robot's.
    pub child_frame_id: Text,
    /// The pose.
    pub pose: PoseWithCovariance,
    /// The velocity.
    pub twist: TwistWithCovariance,
}

/// Size and place of a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapMetaData {
    /// Time at which the map was loaded.
    pub map_load_time: Time,
    /// Side of a cell, m.
    pub resolution: f32,
    /// Cells in a row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// Pose of the lower left corner of the lower left cell.
    pub origin: Pose,
}

/// A map of cells.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OccupancyGrid {
    /// Time and frame.
    pub header: Header,
    /// Size and place.
    pub info: MapMetaData,
    /// Probability of each cell in percent, row by row from the lower left; −1: unknown.
    pub data: Vec<i8>,
}

impl RosMessage for Odometry {
    const NAME: &'static str = "nav_msgs/msg/Odometry";
}
impl RosMessage for OccupancyGrid {
    const NAME: &'static str = "nav_msgs/msg/OccupancyGrid";
}
