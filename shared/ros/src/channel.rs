//! Topics: names, types and quality of service.

use std::collections::BTreeSet;

use crate::cdr::RosMessage;
use crate::description::Description;
use crate::messages::{
    Clock, Imu, LaserScan, MarkerArray, OccupancyGrid, Odometry, PointCloud2, PoseStamped,
    PoseWithCovarianceStamped, Range, TfMessage, TwistStamped,
};
use crate::schema::schema;

/// Content of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Time.
    Clock,
    /// Poses of frames that do not move in each other.
    StaticFrames,
    /// The walls as cells.
    Map,
    /// Walls and landmarks as shapes.
    Markers,
    /// Poses of frames that move.
    Frames,
    /// Dead reckoning.
    Odometry,
    /// Command.
    Command,
    /// Ranges of the LiDAR.
    Scan,
    /// The same as points.
    ScanPoints,
    /// Yaw rate and acceleration.
    Imu,
    /// Range of the sonar with this index.
    Sonar(usize),
    /// Pose of the estimator with this index.
    Pose(usize),
    /// True pose.
    Truth,
}

/// A topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Name, such as `/scan`.
    pub topic: String,
    /// Type, such as `sensor_msgs/msg/LaserScan`.
    pub type_name: &'static str,
    /// Its messages are few, and a subscriber that comes later needs them too: transient
    /// local in ROS 2.
    pub is_latched: bool,
    /// Content.
    pub content: Content,
}

impl Channel {
    fn new<M: RosMessage>(topic: impl Into<String>, content: Content) -> Self {
        let is_latched = matches!(content, Content::StaticFrames | Content::Map | Content::Markers);
        Self { topic: topic.into(), type_name: M::NAME, is_latched, content }
    }

    /// Returns the definition of the type with those within it.
    #[must_use]
    pub fn schema(&self) -> String {
        schema(self.type_name)
    }

    /// Returns the quality of service in the YAML of rosbag2, with numbers as Humble
    /// reads them: reliable; transient local where it is latched.
    #[must_use]
    pub fn qos(&self) -> String {
        const FOREVER: &str = "\n    sec: 9223372036\n    nsec: 854775807";
        let (depth, durability) = if self.is_latched { (1, 1) } else { (10, 2) };
        format!(
            "- history: 1\n  depth: {depth}\n  reliability: 1\n  durability: {durability}\n  \
             deadline:{FOREVER}\n  lifespan:{FOREVER}\n  liveliness: 1\n  \
             liveliness_lease_duration:{FOREVER}\n  avoid_ros_namespace_conventions: false\n"
        )
    }
}

/// Returns the topics of a run.
pub(crate) fn channels(about: &Description) -> Vec<Channel> {
    let has_walls = about.world.as_ref().is_some_and(|world| !world.walls.is_empty());
    let has_shapes = about.world.as_ref().is_some_and(|world| !world.landmarks.is_empty());
    let sonars = about.sensors.sonar.as_ref().map_or(0, |sonar| sonar.mounts.len());
    let mut list = vec![
        Channel::new::<Clock>("/clock", Content::Clock),
        Channel::new::<TfMessage>("/tf_static", Content::StaticFrames),
    ];
    if has_walls {
        list.push(Channel::new::<OccupancyGrid>("/map", Content::Map));
    }
    if has_walls || has_shapes {
        list.push(Channel::new::<MarkerArray>("/markers", Content::Markers));
    }
    list.push(Channel::new::<TfMessage>("/tf", Content::Frames));
    list.push(Channel::new::<Odometry>("/odom", Content::Odometry));
    if about.has_commands {
        list.push(Channel::new::<TwistStamped>("/cmd_vel", Content::Command));
    }
    list.push(Channel::new::<LaserScan>("/scan", Content::Scan));
    list.push(Channel::new::<PointCloud2>("/scan_points", Content::ScanPoints));
    if about.sensors.imu.is_some() {
        list.push(Channel::new::<Imu>("/imu", Content::Imu));
    }
    let sonar = |k: usize| Channel::new::<Range>(format!("/sonar_{k}"), Content::Sonar(k));
    list.extend((0..sonars).map(sonar));
    let pose = |(k, name): (usize, String)| {
        Channel::new::<PoseWithCovarianceStamped>(format!("/{name}/pose"), Content::Pose(k))
    };
    list.extend(names(&about.estimators).into_iter().enumerate().map(pose));
    if about.truth {
        list.push(Channel::new::<PoseStamped>("/truth/pose", Content::Truth));
    }
    list
}

/// Returns names as ROS allows them in a topic: letters, digits and `_`, not first a
/// digit, each different from the others and from `truth`.
fn names(estimators: &[String]) -> Vec<String> {
    let mut taken = BTreeSet::from(["truth".to_owned()]);
    let allowed = |name: &String| {
        let plain: String =
            name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let plain = if plain.starts_with(|c: char| c.is_ascii_digit()) {
            format!("_{plain}")
        } else {
            plain
        };
        let numbered = (2..).map(|k| format!("{plain}_{k}"));
        let free = std::iter::once(plain.clone()).chain(numbered).find(|n| !taken.contains(n));
        let name = free.unwrap_or(plain);
        taken.insert(name.clone());
        name
    };
    estimators.iter().map(allowed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_participant_has_a_topic_that_ros_allows_and_no_other_has() {
        let given = ["dead-reckoning", "dead_reckoning", "truth", "3d", "ekf"].map(str::to_owned);
        let expected = ["dead_reckoning", "dead_reckoning_2", "truth_2", "_3d", "ekf"];
        assert_eq!(names(&given), expected);
    }
}
