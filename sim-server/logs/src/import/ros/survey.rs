//! The facts of a recording of ROS that decide how it is read: topics, the LiDAR and its
//! mount, true poses.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use rusty_contract::MAX_BEAMS;
use rusty_contract::config::LidarConfig;
use rusty_geometry::SE2;
use rusty_ros::messages::{LaserScan, Odometry, Quaternion, TfMessage};

use super::RosOptions;
use super::content::{FRAMES, ODOMETRY, SCAN, decode, frame, stamp_s};
use super::files::{Files, Message};
use super::pose::StampedPose;
use crate::import::preview::StampIntervals;
use crate::import::{ImportError, Progress};

/// Longest time between two true poses across which they are interpolated, s.
const TRUTH_GAP_S: f64 = 0.5;
/// Cosine of the tilt from which a LiDAR is not level: 26°.
const LEVEL: f64 = 0.9;
/// Most frames of which one is found in another.
pub(super) const MOST_FRAMES: usize = 64;

/// What a topic holds.
#[derive(Debug, Default)]
pub(super) struct Topic {
    pub(super) type_name: String,
    pub(super) messages: u64,
    stamps: StampIntervals,
    /// The first scan.
    scan: Option<LaserScan>,
    /// Frame whose pose the odometry is.
    child: String,
}

/// A recording, read once for its facts.
#[derive(Debug, Default)]
pub(super) struct Look {
    pub(super) topics: BTreeMap<String, Topic>,
    pub(super) messages: u64,
    /// Each frame that does not move in its parent: the parent, the pose, and the cosine
    /// of the tilt.
    mounts: BTreeMap<String, (String, SE2, f64)>,
    /// The frame that moves in `odom`, and in which topic.
    moving: Option<(String, String)>,
    pub(super) truth: Vec<(f64, SE2)>,
}

/// Where the odometry is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum OdometrySource {
    /// Messages of [`ODOMETRY`].
    Topic(String),
    /// Frames: the topic, and the frame that moves in `odom`.
    Frames(String, String),
}

impl OdometrySource {
    pub(super) fn topic(&self) -> &str {
        match self {
            Self::Topic(topic) | Self::Frames(topic, _) => topic,
        }
    }
}

/// The beams that are taken from each scan.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Beams {
    pub(super) topic: String,
    /// As a run has it.
    pub(super) lidar: LidarConfig,
    /// Number of beams of a scan in the recording.
    pub(super) given: usize,
    /// Every N-th of the first `taken` is used.
    pub(super) taken: usize,
    pub(super) every: usize,
    /// The angle falls from beam to beam.
    pub(super) is_reversed: bool,
    pub(super) range_min_m: f64,
    pub(super) mount_from: &'static str,
}

impl Look {
    pub(super) fn read(
        paths: &[PathBuf],
        options: &RosOptions,
        progress: &mut Progress<'_>,
    ) -> Result<Self, ImportError> {
        let (mut files, mut look) = (Files::open(paths.to_vec()), Self::default());
        loop {
            let path = files.path.clone();
            let Some(message) = files.advance()? else { break };
            progress.at(message.number);
            look.take(&path, &message, options)?;
        }
        look.messages = files.number;
        look.truth.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(look)
    }

    fn take(
        &mut self,
        path: &str,
        message: &Message<'_>,
        options: &RosOptions,
    ) -> Result<(), ImportError> {
        let (name, type_name) = (&message.channel.topic, &message.channel.type_name);
        if options.truth.as_ref() == Some(name) {
            let found = StampedPose::read(path, message, "--truth")?;
            self.truth.push((found.stamp_s, found.pose));
        }
        let topic = self.topics.entry(name.clone()).or_default();
        topic.messages += 1;
        if topic.type_name.is_empty() {
            topic.type_name.clone_from(type_name);
        }
        match type_name.as_str() {
            SCAN => {
                let mut scan: LaserScan = decode(path, message)?;
                topic.stamps.see(stamp_s(scan.header.stamp, message));
                if topic.scan.is_none() {
                    scan.intensities = Vec::new();
                    topic.scan = Some(scan);
                }
            }
            ODOMETRY => {
                let odometry: Odometry = decode(path, message)?;
                topic.stamps.see(stamp_s(odometry.header.stamp, message));
                topic.child = frame(&odometry.child_frame_id).to_owned();
            }
            FRAMES => self.frames(decode(path, message)?, name),
            _ => {}
        }
        Ok(())
    }

    fn frames(&mut self, message: TfMessage, topic: &str) {
        for moved in message.transforms {
            let (parent, child) = (frame(&moved.header.frame_id), frame(&moved.child_frame_id));
            let Quaternion { x, y, .. } = moved.transform.rotation;
            if topic.ends_with("tf_static") {
                let mount =
                    (parent.to_owned(), moved.transform.into(), 1.0 - 2.0 * (x * x + y * y));
                self.mounts.insert(child.to_owned(), mount);
            } else if parent.ends_with("odom") && self.moving.is_none() {
                self.moving = Some((topic.to_owned(), child.to_owned()));
            }
        }
    }

    /// The stamps of the scans (without scans: of the odometry), if most of them repeat
    /// the one before.
    pub(super) fn flat(&self, scan: Option<&str>, odometry: &str) -> Option<StampIntervals> {
        let stamps = |topic: &str| self.topics.get(topic).map(|topic| topic.stamps);
        let scans = scan.and_then(stamps).filter(|stamps| stamps.intervals > 0);
        let stamps = scans.or_else(|| stamps(odometry)).unwrap_or_default();
        (2 * stamps.standing > stamps.intervals).then_some(stamps)
    }

    /// The topic of the odometry: the one that was named, or the only one.
    pub(super) fn odometry(
        &self,
        input: &Path,
        wanted: Option<&String>,
    ) -> Result<OdometrySource, ImportError> {
        if let (Some((topic, child)), Some(wanted)) = (&self.moving, wanted)
            && topic == wanted
        {
            return Ok(OdometrySource::Frames(topic.clone(), child.clone()));
        }
        match (self.choose(input, ODOMETRY, "--odom", wanted)?, &self.moving) {
            (Some(topic), _) => Ok(OdometrySource::Topic(topic)),
            (None, Some((topic, child))) => {
                Ok(OdometrySource::Frames(topic.clone(), child.clone()))
            }
            (None, None) => {
                let problem = format!(
                    "expected odometry ({ODOMETRY}, or a frame that moves in odom), got none in \
                     {}; record /odom or /tf, too",
                    self.list()
                );
                Err(ImportError::file(input, problem))
            }
        }
    }

    /// The topic of a type that was named, or the only one; `None`: no topic has the type.
    pub(super) fn choose(
        &self,
        input: &Path,
        type_name: &str,
        option: &str,
        wanted: Option<&String>,
    ) -> Result<Option<String>, ImportError> {
        let of_type = self.topics.iter().filter(|(_, topic)| topic.type_name == type_name);
        let found: Vec<&String> = of_type.map(|(name, _)| name).collect();
        match (wanted, &found[..]) {
            (None, []) => Ok(None),
            (None, [one]) => Ok(Some((*one).clone())),
            (Some(wanted), _) if found.contains(&wanted) => Ok(Some(wanted.clone())),
            _ => {
                let got = wanted.map_or_else(|| "several".to_owned(), |w| format!("{w:?}"));
                let problem = format!(
                    "expected one topic of {type_name}, got {got}; name one with {option}: the \
                     recording has {}",
                    self.list()
                );
                Err(ImportError::file(input, problem))
            }
        }
    }

    /// All topics with types and numbers.
    pub(super) fn list(&self) -> String {
        let of = |(name, topic): (&String, &Topic)| {
            format!("{name} ({}, {})", topic.type_name, topic.messages)
        };
        let list: Vec<String> = self.topics.iter().take(MOST_FRAMES).map(of).collect();
        if list.is_empty() { "no topics".to_owned() } else { list.join(", ") }
    }

    /// The beams of the scans of a topic, on a body whose odometry is `source`.
    pub(super) fn beams(
        &self,
        input: &Path,
        topic: &str,
        source: &OdometrySource,
        offset: Option<SE2>,
    ) -> Result<Option<Beams>, ImportError> {
        let Some(scan) = self.topics.get(topic).and_then(|topic| topic.scan.as_ref()) else {
            return Ok(None);
        };
        let step_rad = f64::from(scan.angle_increment).abs();
        let given = scan.ranges.len();
        // A beam that looks where the first did belongs to the next turn.
        let turn = (TAU / step_rad + 1e-3).floor();
        if !(step_rad > 0.0 && turn >= 1.0) {
            let problem =
                format!("{topic}: angle_increment {step_rad} rad is not an angle; mend it");
            return Err(ImportError::file(input, problem));
        }
        let taken = given.min(turn.min(1e9) as usize);
        let every = taken.div_ceil(MAX_BEAMS).max(1);
        let beams = taken.div_ceil(every);
        let is_reversed = scan.angle_increment < 0.0;
        let first_rad = f64::from(scan.angle_min);
        let last = (beams.saturating_sub(1) * every) as f64;
        let (mount, mount_from) = match offset {
            Some(offset) => (offset, "as given"),
            None => self.mount(input, frame(&scan.header.frame_id), source)?,
        };
        let lidar = LidarConfig {
            beams: beams as u32,
            first_bearing_rad: if is_reversed { first_rad - last * step_rad } else { first_rad },
            fov_rad: (step_rad * (beams * every) as f64).min(TAU),
            range_max_m: f64::from(scan.range_max),
            range_std_m: 0.01,
            sensor_in_body: mount,
            ..LidarConfig::default()
        };
        let range_min_m = f64::from(scan.range_min);
        let topic = topic.to_owned();
        Ok(Some(Beams { topic, lidar, given, taken, every, is_reversed, range_min_m, mount_from }))
    }

    /// The pose of the LiDAR's frame on the body, and what tells it.
    fn mount(
        &self,
        input: &Path,
        laser: &str,
        source: &OdometrySource,
    ) -> Result<(SE2, &'static str), ImportError> {
        let body = match source {
            OdometrySource::Topic(topic) => self.topics.get(topic).map_or("", |topic| &topic.child),
            OdometrySource::Frames(_, child) => child,
        };
        let (mut at, mut mount, mut level) = (laser, SE2::identity(), 1.0);
        for _ in 0..MOST_FRAMES {
            let Some((parent, pose, tilt)) = self.mounts.get(at).filter(|_| at != body) else {
                break;
            };
            (mount, at) = (*pose * mount, parent);
            level *= tilt;
        }
        if level < LEVEL {
            let problem = format!(
                "expected a level LiDAR, got the frame {laser} tilted or upside down; give the \
                 mount with --laser-offset X,Y,DEG if its scans are turned already"
            );
            return Err(ImportError::file(input, problem));
        }
        Ok(match (at == body, at == laser) {
            (_, true) if laser != body => (mount, "assumed: no static frame leads to it"),
            (true, _) => (mount, "by the static frames"),
            (false, _) => (mount, "by the static frames, which end before the odometry's frame"),
        })
    }
}

/// The true pose at a time, where it is known: between two that are near, the part of the
/// way that belongs to it.
pub(super) fn truth_at(truth: &[(f64, SE2)], stamp_s: f64) -> Option<SE2> {
    let after = truth.partition_point(|(at_s, _)| *at_s < stamp_s);
    let (after_s, next) = truth.get(after)?;
    if *after_s == stamp_s {
        return Some(*next);
    }
    let (before_s, last) = truth.get(after.checked_sub(1)?)?;
    let part = (stamp_s - before_s) / (after_s - before_s);
    (after_s - before_s <= TRUTH_GAP_S).then(|| last.boxplus(&(next.boxminus(last) * part)))
}
