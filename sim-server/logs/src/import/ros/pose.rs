//! Poses with stamps, of the messages that carry one.

use rusty_geometry::SE2;
use rusty_ros::messages::{Header, Odometry, Pose, PoseStamped, PoseWithCovarianceStamped};

use super::content::{ODOMETRY, decode, stamp_s};
use super::files::Message;
use crate::import::ImportError;

pub(super) const WITH_COVARIANCE: &str = "geometry_msgs/msg/PoseWithCovarianceStamped";
const STAMPED: &str = "geometry_msgs/msg/PoseStamped";

/// A pose with its stamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StampedPose {
    pub(super) stamp_s: f64,
    pub(super) pose: SE2,
    /// xx, xy, xθ, yy, yθ, θθ in the frame of the header; `None`: not known.
    pub(super) covariance: Option<[f64; 6]>,
}

impl StampedPose {
    /// Reads a message of the topic that `option` named.
    pub(super) fn read(
        path: &str,
        message: &Message<'_>,
        option: &str,
    ) -> Result<Self, ImportError> {
        let of = |header: Header, pose: Pose, covariance: Option<[f64; 36]>| Self {
            stamp_s: stamp_s(header.stamp, message),
            pose: SE2::from(pose),
            // Zeros say that it is not known.
            covariance: covariance
                .map(|all| [0, 1, 5, 7, 11, 35].map(|at| all[at]))
                .filter(|planar| planar.iter().any(|v| *v != 0.0)),
        };
        let channel = message.channel;
        let found = match channel.type_name.as_str() {
            ODOMETRY => {
                let m: Odometry = decode(path, message)?;
                of(m.header, m.pose.pose, Some(m.pose.covariance))
            }
            STAMPED => {
                let m: PoseStamped = decode(path, message)?;
                of(m.header, m.pose, None)
            }
            WITH_COVARIANCE => {
                let m: PoseWithCovarianceStamped = decode(path, message)?;
                of(m.header, m.pose.pose, Some(m.pose.covariance))
            }
            other => {
                let problem = format!(
                    "{option} {}: expected one of {ODOMETRY}, {STAMPED}, {WITH_COVARIANCE}, got {other}",
                    channel.topic
                );
                return Err(ImportError::line(path, message.number, problem));
            }
        };
        found.checked(path, message)
    }

    /// A pose of frames, without a covariance.
    pub(super) fn of(
        stamp_s: f64,
        pose: SE2,
        path: &str,
        message: &Message<'_>,
    ) -> Result<Self, ImportError> {
        Self { stamp_s, pose, covariance: None }.checked(path, message)
    }

    fn checked(self, path: &str, message: &Message<'_>) -> Result<Self, ImportError> {
        let entries = self.covariance.iter().flatten();
        if self.pose.is_finite() && entries.chain([&self.stamp_s]).all(|v| v.is_finite()) {
            return Ok(self);
        }
        let topic = &message.channel.topic;
        let problem = format!("message of {topic}: the pose is not finite; mend the recording");
        Err(ImportError::line(path, message.number, problem))
    }
}
