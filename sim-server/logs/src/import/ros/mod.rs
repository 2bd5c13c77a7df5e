//! Recordings of ROS 2: MCAP files, and folders of rosbag2 with them.
//!
//! In reading order: `bag` (which files), `files` (messages), `content` (what messages have
//! in common), `survey` (topics, LiDAR, truth), `recording` (messages as events), `pose`
//! (poses with stamps), `trajectory` (the poses of an estimator alone). Departures: a scan
//! and odometry of one stamp are one tick; true poses are those of a topic that is named, at
//! the times of the scans.

mod bag;
mod content;
mod files;
mod pose;
mod recording;
mod survey;
mod trajectory;

use std::path::Path;
use std::rc::Rc;

use rusty_geometry::SE2;

use super::convert::import;
use super::recording::Events;
use super::survey::Told;
use super::{ImportError, ImportOptions, ImportReport, Progress};
use content::SCAN;
use recording::{Choice, RosRecording};
use survey::{Look, OdometrySource};
pub use trajectory::{Poses, TrajectoryReport, import_trajectory};

/// What is read of a recording of ROS.
#[derive(Clone, Debug, Default)]
pub struct RosOptions {
    /// Topic of the scans; `None`: the only one.
    pub scan: Option<String>,
    /// Topic of the odometry, or of frames; `None`: the only one.
    pub odom: Option<String>,
    /// Topic of the true poses; `None`: the import has no truth.
    pub truth: Option<String>,
    /// Pose of the LiDAR on the body; `None`: that of the static frames.
    pub laser_offset: Option<SE2>,
}

/// Imports the MCAP file `input`, or with `is_bag` the folder of rosbag2, into the run log
/// `output`, as [`import_carmen`](super::import_carmen) does with its format. Lines are
/// messages, of all topics.
///
/// # Errors
/// [`ImportError`] names file, message, topic, value and remedy.
pub fn import_ros(
    input: &Path,
    is_bag: bool,
    output: &Path,
    ros: &RosOptions,
    options: ImportOptions<'_>,
    progress: &mut dyn FnMut(u64),
) -> Result<ImportReport, ImportError> {
    let paths = bag::files(input, is_bag)?;
    let mut progress = Progress::new(progress);
    let look = Look::read(&paths, ros, &mut progress)?;
    progress.pass(look.messages);
    let odometry = look.odometry(input, ros.odom.as_ref())?;
    let scan = look.choose(input, SCAN, "--scan", ros.scan.as_ref())?;
    if ros.truth.is_some() && look.truth.is_empty() {
        let wanted = ros.truth.as_deref().unwrap_or_default();
        let problem = format!("--truth {wanted}: no such topic; the recording has {}", look.list());
        return Err(ImportError::file(input, problem));
    }
    let beams = match &scan {
        Some(topic) => look.beams(input, topic, &odometry, ros.laser_offset)?,
        None => None,
    };
    let told = Told {
        format: if is_bag { "rosbag2" } else { "mcap" },
        flat: look.flat(scan.as_deref(), odometry.topic()),
        lidar: beams.as_ref().map(|beams| beams.lidar),
        remarks: remarks(&odometry, beams.as_ref(), ros),
    };
    let choice = Rc::new(Choice { odometry, beams, truth: look.truth });
    let open = || Ok(Box::new(RosRecording::open(&paths, Rc::clone(&choice))) as Box<dyn Events>);
    import(input, output, options, told.into(), &open, &mut progress)
}

/// What a reader should know of the choice.
fn remarks(
    odometry: &OdometrySource,
    beams: Option<&survey::Beams>,
    ros: &RosOptions,
) -> Vec<String> {
    let mut list = vec![match odometry {
        OdometrySource::Topic(topic) => format!("the odometry is that of {topic}"),
        OdometrySource::Frames(topic, child) => {
            format!("the odometry is the pose of {child} in odom, of {topic}")
        }
    }];
    if let Some(beams) = beams {
        let mount = beams.lidar.sensor_in_body;
        list.push(format!(
            "scans are those of {}; the LiDAR is at x = {} m, y = {} m, {:.2}° on the body ({}); \
             ranges that are not from {} m to {} m mean that nothing came back; the spread of a \
             range, {} m, is assumed",
            beams.topic,
            mount.x(),
            mount.y(),
            mount.theta().to_degrees(),
            beams.mount_from,
            beams.range_min_m,
            beams.lidar.range_max_m,
            beams.lidar.range_std_m
        ));
        if beams.every > 1 || beams.taken < beams.given {
            list.push(format!(
                "of the {} beams of a scan {} are taken, every {}-th of the first {}",
                beams.given, beams.lidar.beams, beams.every, beams.taken
            ));
        }
    }
    if let Some(truth) = &ros.truth {
        list.push(format!(
            "true poses are those of {truth}, interpolated at the times of the scans"
        ));
    }
    list
}
