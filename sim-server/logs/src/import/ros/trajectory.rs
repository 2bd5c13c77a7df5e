//! The poses of an estimator in a recording of ROS, as a trajectory in TUM format.
//!
//! They are those of a topic, or of a frame in another one, as slam_toolbox and
//! Cartographer say them: the transforms between the two are composed whenever the one
//! that is next to the child and moves is new, with the latest of the others.

use std::collections::BTreeMap;
use std::fmt;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use rusty_contract::{Replacement, tum};
use rusty_geometry::SE2;
use rusty_ros::messages::TfMessage;
use serde::Serialize;

use super::RosOptions;
use super::bag;
use super::content::{FRAMES, decode, frame, stamp_s};
use super::files::Files;
use super::pose::{StampedPose, WITH_COVARIANCE};
use super::survey::{Look, MOST_FRAMES};
use crate::import::convert::check_two_files;
use crate::import::{ImportError, Progress};

/// Which poses are read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Poses {
    /// Those of a topic; `None`: of the only one with poses and covariances.
    Topic(Option<String>),
    /// Those of the frame `child` in the frame `parent`.
    Frames {
        /// Frame in which the poses are, such as `map`.
        parent: String,
        /// Frame whose poses they are, such as `base_link`.
        child: String,
    },
}

/// The poses that were written.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrajectoryReport {
    /// Topic, or frames.
    pub source: String,
    /// Number of poses.
    pub poses: u64,
    /// Those with a covariance.
    pub with_covariance: u64,
    /// First stamp, s.
    pub first_stamp_s: f64,
    /// Last stamp, s.
    pub last_stamp_s: f64,
}

/// Writes the poses of `input`, an MCAP file or a folder of rosbag2, to `output`: lines of
/// `timestamp tx ty tz qx qy qz qw`, then, where the message has a covariance, its
/// entries xx, xy, xθ, yy, yθ, θθ in the frame of the poses. `progress` receives the number
/// of each message.
///
/// # Errors
/// [`ImportError`] names file, message, topic, value and remedy.
pub fn import_trajectory(
    input: &Path,
    output: &Path,
    poses: &Poses,
    progress: &mut dyn FnMut(u64),
) -> Result<TrajectoryReport, ImportError> {
    check_two_files(input, output)?;
    let paths = bag::files(input, input.is_dir())?;
    let look = Look::read(&paths, &RosOptions::default(), &mut Progress::new(&mut |_| ()))?;
    let mut reader = Reader::open(paths, choose(poses, &look, input)?);
    let failed = |action: &'static str| {
        move |error: std::io::Error| {
            let problem = format!("{action}: {error}; choose a folder that can be written to");
            ImportError::file(output, problem)
        }
    };
    let writing = failed("writing the trajectory");
    let mut file = BufWriter::new(Replacement::of(output).map_err(writing)?);
    let mut report = TrajectoryReport {
        source: reader.source.to_string(),
        poses: 0,
        with_covariance: 0,
        first_stamp_s: f64::INFINITY,
        last_stamp_s: f64::NEG_INFINITY,
    };
    while let Some(found) = reader.next(progress)? {
        report.take(&found);
        let mut text = tum::line(found.stamp_s, &found.pose);
        for entry in found.covariance.iter().flatten() {
            text += &format!(" {entry:?}");
        }
        writeln!(file, "{text}").map_err(writing)?;
    }
    if report.poses == 0 {
        let has = match reader.source {
            Poses::Topic(_) => look.list(),
            Poses::Frames { .. } => reader.links.list(),
        };
        let problem = format!("no poses of {}; the recording has {has}", reader.source);
        return Err(ImportError::file(input, problem));
    }
    let file = file.into_inner().map_err(|e| writing(e.into_error()))?;
    file.commit(output).map_err(failed("completing the trajectory"))?;
    Ok(report)
}

impl TrajectoryReport {
    fn take(&mut self, found: &StampedPose) {
        self.poses += 1;
        self.with_covariance += u64::from(found.covariance.is_some());
        self.first_stamp_s = self.first_stamp_s.min(found.stamp_s);
        self.last_stamp_s = self.last_stamp_s.max(found.stamp_s);
    }
}

/// The poses that are read, with a topic for certain.
fn choose(poses: &Poses, look: &Look, input: &Path) -> Result<Poses, ImportError> {
    let topic = match poses {
        Poses::Frames { .. } => return Ok(poses.clone()),
        Poses::Topic(Some(topic)) => Some(topic.clone()).filter(|t| look.topics.contains_key(t)),
        Poses::Topic(None) => look.choose(input, WITH_COVARIANCE, "--topic", None)?,
    };
    let topic = topic.ok_or_else(|| {
        let problem = match poses {
            Poses::Topic(Some(topic)) => format!("--topic {topic} is not in it"),
            _ => "expected the topic of the poses".to_owned(),
        };
        let problem = format!(
            "{problem}; name the topic of the poses with --topic, or the frames with --frames: the \
             recording has {}",
            look.list()
        );
        ImportError::file(input, problem)
    })?;
    Ok(Poses::Topic(Some(topic)))
}

/// Reads the poses one after the other.
struct Reader {
    files: Files,
    source: Poses,
    links: Links,
}

impl Reader {
    fn open(paths: Vec<PathBuf>, source: Poses) -> Self {
        Self { files: Files::open(paths), source, links: Links::default() }
    }

    fn next(&mut self, progress: &mut dyn FnMut(u64)) -> Result<Option<StampedPose>, ImportError> {
        loop {
            let path = self.files.path.clone();
            let Some(message) = self.files.advance()? else { return Ok(None) };
            progress(message.number);
            let channel = message.channel;
            match &self.source {
                Poses::Topic(Some(topic)) if *topic == channel.topic => {
                    return StampedPose::read(&path, &message, "--topic").map(Some);
                }
                Poses::Frames { parent, child } if channel.type_name == FRAMES => {
                    let is_static = channel.topic.ends_with("tf_static");
                    let news: TfMessage = decode(&path, &message)?;
                    for link in &news.transforms {
                        let (of, within) =
                            (frame(&link.child_frame_id), frame(&link.header.frame_id));
                        self.links.set(of, within, link.transform.into(), is_static);
                    }
                    let moved = news.transforms.iter().rev().find_map(|link| {
                        let pose = self.links.moved(frame(&link.child_frame_id), child, parent)?;
                        Some((stamp_s(link.header.stamp, &message), pose))
                    });
                    if let Some((stamp_s, pose)) = moved {
                        return StampedPose::of(stamp_s, pose, &path, &message).map(Some);
                    }
                }
                _ => {}
            }
        }
    }
}

/// Each frame's parent, its latest pose there, and whether it never moves.
#[derive(Debug, Default)]
struct Links(BTreeMap<String, (String, SE2, bool)>);

impl Links {
    fn set(&mut self, child: &str, parent: &str, pose: SE2, is_static: bool) {
        if self.0.len() < MOST_FRAMES || self.0.contains_key(child) {
            self.0.insert(child.to_owned(), (parent.to_owned(), pose, is_static));
        }
    }

    /// The pose of `child` in `parent`, if `new` is the link next to `child` that moves.
    fn moved(&self, new: &str, child: &str, parent: &str) -> Option<SE2> {
        let (mut at, mut pose, mut moving) = (child, SE2::identity(), None);
        for _ in 0..MOST_FRAMES {
            if at == parent {
                return (moving == Some(new)).then_some(pose);
            }
            let (within, link, is_static) = self.0.get(at)?;
            if !is_static {
                moving = moving.or(Some(at));
            }
            (at, pose) = (within, *link * pose);
        }
        None
    }

    fn list(&self) -> String {
        let links = self.0.iter().map(|(child, (parent, ..))| format!("{child} in {parent}"));
        let links: Vec<String> = links.collect();
        if links.is_empty() { "no frames".to_owned() } else { links.join(", ") }
    }
}

impl fmt::Display for Poses {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Topic(topic) => f.write_str(topic.as_deref().unwrap_or("the topic with poses")),
            Self::Frames { parent, child } => write!(f, "frame {child} in {parent}"),
        }
    }
}
