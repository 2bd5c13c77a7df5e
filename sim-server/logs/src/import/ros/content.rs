//! What all messages of a recording have in common: types by name, CDR, stamps, frames.

use rusty_ros::from_cdr;
use rusty_ros::messages::Time;
use serde::de::DeserializeOwned;

use super::files::Message;
use crate::import::ImportError;

pub(super) const SCAN: &str = "sensor_msgs/msg/LaserScan";
pub(super) const ODOMETRY: &str = "nav_msgs/msg/Odometry";
pub(super) const FRAMES: &str = "tf2_msgs/msg/TFMessage";

/// Reads a message of a type.
pub(super) fn decode<M: DeserializeOwned>(
    path: &str,
    message: &Message<'_>,
) -> Result<M, ImportError> {
    let failed = |problem: String| {
        let topic = &message.channel.topic;
        let problem = format!("message of {topic} ({}): {problem}", message.channel.type_name);
        ImportError::line(path, message.number, problem)
    };
    if message.channel.encoding != "cdr" {
        return Err(failed(format!(
            "expected the encoding cdr of ROS 2, got {:?}; convert it: pip install rosbags, then \
             rosbags-convert --src RECORDING --dst bag --dst-storage mcap",
            message.channel.encoding
        )));
    }
    from_cdr(message.data).map_err(|error| failed(error.to_string()))
}

/// The stamp of a header, or the time of recording where none was set.
pub(super) fn stamp_s(stamp: Time, message: &Message<'_>) -> f64 {
    if stamp == Time::default() { message.log_s } else { stamp.seconds() }
}

/// A frame's name without the slash that ROS 1 put in front.
pub(super) fn frame(name: &str) -> &str {
    name.trim_start_matches('/')
}
