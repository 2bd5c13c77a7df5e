//! `import`: convert recordings of real robots into run logs.

use std::io::IsTerminal as _;
use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, Subcommand};
use rusty_contract::{Exit, errln, outln};
use rusty_geometry::SE2;
use rusty_logs::import::ros::{RosOptions, import_ros};
use rusty_logs::import::{self, ImportOptions, ImportReport};

use super::WRITER;
use super::arguments::{Output, check_free};

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

/// Number of lines between two lines of progress.
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

pub fn run(format: &ImportFormat) -> Result<Exit> {
    match format {
        ImportFormat::Carmen(args) => convert(&args.files, |files, options, progress| {
            import::import_carmen(&files.input, &files.log, options, progress)
        }),
        ImportFormat::Mcap(args) => ros(args, false),
        ImportFormat::Rosbag(args) => ros(args, true),
    }
}

fn ros(args: &RosArgs, is_bag: bool) -> Result<Exit> {
    let RosArgs { scan, odom, truth, laser_offset, .. } = args.clone();
    let ros = RosOptions { scan, odom, truth, laser_offset };
    convert(&args.files, |files, options, progress| {
        import_ros(&files.input, is_bag, &files.log, &ros, options, progress)
    })
}

type Imported = Result<ImportReport, import::ImportError>;

fn convert(
    args: &Files,
    import: impl FnOnce(&Files, ImportOptions<'_>, &mut dyn FnMut(u64)) -> Imported,
) -> Result<Exit> {
    check_free(&args.log, args.force)?;
    let is_shown = std::io::stderr().is_terminal() && !args.output.json;
    let mut progress = |lines: u64| {
        if is_shown && lines.is_multiple_of(PROGRESS_LINES) {
            errln!("  {lines} lines");
        }
    };
    let options = ImportOptions { writer: WRITER, strict: args.strict };
    let report = import(args, options, &mut progress)?;
    args.output.print_with(&report, || {
        outln!("{report}");
        outln!("log       {}", args.log.display());
        outln!("play it   sim-server replay {}", args.log.display());
    });
    Ok(Exit::Done)
}
