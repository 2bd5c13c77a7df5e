//! `import`: convert recordings of real robots into run logs.

use std::io::IsTerminal as _;
use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, Subcommand};
use rusty_contract::{Exit, errln, outln};
use rusty_engine::shell;
use rusty_geometry::SE2;
use rusty_logs::import::ros::{Poses, RosOptions, TrajectoryReport, import_ros, import_trajectory};
use rusty_logs::import::{self, ImportOptions, ImportReport};

use super::WRITER;
use super::arguments::{Output, check_apart, check_free};

const AFTER_ROS: &str = "\
Read are scans (sensor_msgs/LaserScan) and odometry (nav_msgs/Odometry, or the frame
that moves in odom), with the mount of the LiDAR by /tf_static. Where there are several
topics of a type, --scan and --odom name one. Each message of the odometry and each scan
is a tick; a scan and odometry of one stamp are one tick. Chunks may be packed with lz4
or zstd. Other storage is converted first:
  pip install rosbags
  rosbags-convert --src OLD --dst bag --dst-storage mcap
  sim-server import rosbag bag -o robot.log
  sim-server import mcap robot.mcap -o robot.log --truth /ground_truth/pose";

#[derive(Subcommand, Clone, Debug)]
pub enum ImportFormat {
    /// Convert a CARMEN log (ODOM and FLASER), plain or gzip
    Carmen(CarmenArgs),
    /// Convert an MCAP file with messages of ROS 2
    Mcap(RosArgs),
    /// Convert a rosbag2 folder with MCAP files
    Rosbag(RosArgs),
    /// Take the poses of an estimator from a recording of ROS 2, to score them
    Trajectory(TrajectoryArgs),
}

const AFTER_TRAJECTORY: &str = "\
The trajectory is in TUM format, which evo reads, too; where a message has a covariance,
six more numbers follow. Score it on the log of the run, or on the import of the
recording: the stamps must be those of the log.
  sim-server import trajectory bag --topic /amcl_pose -o amcl.tum
  sim-server import trajectory bag --frames map,base_link -o slam_toolbox.tum
  sim-server replay run.log --add amcl=\"trajectory amcl.tum\"";

#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_TRAJECTORY)]
pub struct TrajectoryArgs {
    /// MCAP file or rosbag2 folder to read
    pub input: PathBuf,
    /// Trajectory to write
    #[arg(short = 'o', long = "output", value_name = "FILE")]
    pub trajectory: PathBuf,
    /// Topic of poses or odometry [default: the only one with poses and covariances]
    #[arg(long, value_name = "TOPIC")]
    pub topic: Option<String>,
    /// Poses of the frame CHILD in PARENT, from /tf and /tf_static
    #[arg(long, value_name = "PARENT,CHILD", value_parser = frames, conflicts_with = "topic")]
    pub frames: Option<Poses>,
    /// Replace an existing file
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Args, Clone, Debug)]
pub struct CarmenArgs {
    #[command(flatten)]
    pub files: Files,
}

#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_ROS)]
pub struct RosArgs {
    #[command(flatten)]
    pub files: Files,
    /// Topic of the scans
    #[arg(long, value_name = "TOPIC")]
    pub scan: Option<String>,
    /// Topic of the odometry, or of frames (/tf)
    #[arg(long, value_name = "TOPIC")]
    pub odom: Option<String>,
    /// Topic of the true poses [default: none]
    #[arg(long, value_name = "TOPIC")]
    pub truth: Option<String>,
    /// Pose of the LiDAR on the body, m, m, degrees
    #[arg(long, value_name = "X,Y,DEG", value_parser = pose, allow_hyphen_values = true)]
    pub laser_offset: Option<SE2>,
}

#[derive(Args, Clone, Debug)]
pub struct Files {
    /// Recording to read
    pub input: PathBuf,
    /// Run log to write
    #[arg(short = 'o', long = "output", value_name = "LOG")]
    pub log: PathBuf,
    /// Refuse a recording that has findings
    #[arg(long)]
    pub strict: bool,
    /// Replace an existing run log
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub output: Output,
}

/// Number of lines or messages between two lines of progress.
const PROGRESS_LINES: u64 = 50_000;

fn pose(text: &str) -> Result<SE2, String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|word| word.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y, deg] if numbers.iter().all(|n| n.is_finite()) => {
            Ok(SE2::new(x, y, deg.to_radians()))
        }
        _ => Err("expected three numbers such as 0.1,0,180 (m, m, degrees)".to_owned()),
    }
}

fn frames(text: &str) -> Result<Poses, String> {
    let names: Vec<&str> = text.split(',').map(str::trim).collect();
    match names[..] {
        [parent, child] if !parent.is_empty() && !child.is_empty() && parent != child => {
            Ok(Poses::Frames { parent: parent.to_owned(), child: child.to_owned() })
        }
        _ => Err("expected two frames such as map,base_link".to_owned()),
    }
}

pub fn run(format: &ImportFormat) -> Result<Exit> {
    match format {
        ImportFormat::Carmen(args) => convert(&args.files, "lines", |files, options, progress| {
            import::import_carmen(&files.input, &files.log, options, progress)
        }),
        ImportFormat::Mcap(args) => ros(args, false),
        ImportFormat::Rosbag(args) => ros(args, true),
        ImportFormat::Trajectory(args) => trajectory(args),
    }
}

fn trajectory(args: &TrajectoryArgs) -> Result<Exit> {
    let TrajectoryArgs { input, trajectory, topic, frames, force, output } = args;
    check_free(trajectory, *force)?;
    check_apart([input], [trajectory])?;
    let poses = frames.clone().unwrap_or_else(|| Poses::Topic(topic.clone()));
    let report = import_trajectory(input, trajectory, &poses, &mut shown("messages", output))?;
    output.print_with(&report, || {
        let TrajectoryReport { source, poses, with_covariance, first_stamp_s, last_stamp_s } =
            &report;
        outln!("{poses} poses of {source}, {with_covariance} with a covariance");
        outln!("stamps    {first_stamp_s:?} to {last_stamp_s:?} s");
        let file = trajectory.to_string_lossy();
        outln!("file      {file}");
        let command = format!("trajectory {}", shell::quoted(&file));
        outln!("score it  sim-server replay LOG --add NAME={}", shell::quoted(&command));
    });
    Ok(Exit::Done)
}

/// Shows how far the reading of many lines or messages (`counted`) is, to a person.
fn shown(counted: &'static str, output: &Output) -> impl FnMut(u64) + use<> {
    let is_shown = std::io::stderr().is_terminal() && !output.json;
    move |done: u64| {
        if is_shown && done.is_multiple_of(PROGRESS_LINES) {
            errln!("  {done} {counted}");
        }
    }
}

fn ros(args: &RosArgs, is_bag: bool) -> Result<Exit> {
    let RosArgs { scan, odom, truth, laser_offset, .. } = args.clone();
    let ros = RosOptions { scan, odom, truth, laser_offset };
    convert(&args.files, "messages", |files, options, progress| {
        import_ros(&files.input, is_bag, &files.log, &ros, options, progress)
    })
}

type Imported = Result<ImportReport, import::ImportError>;

fn convert(
    args: &Files,
    counted: &'static str,
    import: impl FnOnce(&Files, ImportOptions<'_>, &mut dyn FnMut(u64)) -> Imported,
) -> Result<Exit> {
    check_free(&args.log, args.force)?;
    check_apart([&args.input], [&args.log])?;
    let options = ImportOptions { writer: WRITER, strict: args.strict };
    let report = import(args, options, &mut shown(counted, &args.output))?;
    args.output.print_with(&report, || {
        outln!("{report}");
        let log = args.log.to_string_lossy();
        outln!("log       {log}");
        outln!("play it   sim-server replay {}", shell::quoted(&log));
    });
    Ok(Exit::Done)
}
