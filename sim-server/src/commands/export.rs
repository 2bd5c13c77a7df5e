//! `export`: write a log for other programs.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use anyhow::Result;
use clap::{Args, Subcommand};
use rusty_contract::{Exit, TextTable, errln, outln};
use rusty_engine::shell;
use rusty_logs::export::mcap::{RosExported, RosOptions};
use rusty_logs::export::tum::Tum;
use rusty_logs::export::{Exported, StampOrder, Walked, csv, mcap, parquet, rosbag, scenario};

use super::arguments::{Output, check_apart};
use super::stop_flag;

const AFTER_TUM: &str = "\
A line is a pose: timestamp tx ty tz qx qy qz qw, in s and m. tz, qx and qy are 0.
Each number has the fewest digits that read back to the same bits. The output
folder is created if necessary.

truth.tum has every tick with a known true pose. NAME.tum has the ticks of an
estimator that `score` scores: those with a true pose and an estimate in effect
(with a modelled compute time, an answer takes effect after that time). So each
line of NAME.tum has a line of truth.tum with the same timestamp, and evo measures
the figures of score.json. Recordings with repeated timestamps are an exception:
evo pairs by time and takes the first.
  sim-server export tum runs/NAME/run.log -o tum
  evo_ape tum tum/truth.tum tum/dead-reckoning.tum
  evo_rpe tum tum/truth.tum tum/dead-reckoning.tum --delta 1 --delta_unit m --pairs_from_reference

A log without true poses (e.g. a blind log) has no truth.tum, and all its estimates
are written. This is reported on stderr; the exit code is 0, because nothing of
the log is lost. Of a truncated or damaged log the readable part is exported; the
exit code is 3.";

const AFTER_CSV: &str = "\
A line per tick has tick, time_s, the encoder counts, the command, the readings of
small sensors, the true pose, and for every participant that answers, the pose in
effect and its reported variances (the diagonal of the covariance in m², m², rad²,
in the frame of the estimate). Missing values are empty. Angles are in rad, in
(-π, π].

  sim-server export csv runs/NAME/run.log -o run.csv";

const AFTER_PARQUET: &str = "\
A row per tick has the columns of `export csv`, the scan as a list (ranges_m, null in
ticks without one), and lists of the small sensors: sonar_m, doors, landmarks.id (-1
where it is unknown), landmarks.range_m, landmarks.bearing_rad. Missing values are null.

  sim-server export parquet runs/NAME/run.log -o run.parquet
  python3 -c \"import pandas; print(pandas.read_parquet('run.parquet'))\"
  duckdb -c \"select tick, list_min(ranges_m) from 'run.parquet'\"";

const AFTER_ROS: &str = "\
The messages of ROS 2 (CDR) and their topics are in docs/ros.md: /scan, /scan_points,
/odom, /tf, /map, /NAME/pose of each participant that answers, and more. The frame odom
moves in map by the estimates of the first of them, or of --estimator NAME; with none it
does not, which leaves it to a program that reads the bag. The truth is written only
with --truth, to /truth/pose. One log gives the same bytes on every machine.

  sim-server export mcap runs/NAME/run.log -o run.mcap
  sim-server export rosbag runs/NAME/run.log -o bag
  ros2 bag play bag";

const AFTER_SCENARIO: &str = "\
The folder gets scenario.toml, commands.txt with the commands of a driver, and
world.toml if the world is not a built-in one. The run of the scenario has the frames of
the log, bit for bit (the same world digest), without the driver: a drive by hand is
repeated without the person. Of a truncated log the readable part is exported.

  sim-server export scenario runs/NAME/run.log -o drive-1
  sim-server launch drive-1/scenario.toml --add mine=./target/release/mine";

#[derive(Args, Clone, Debug)]
pub struct ExportArgs {
    /// Output format
    #[command(subcommand)]
    pub what: ExportVerb,
}

#[derive(Subcommand, Clone, Debug)]
pub enum ExportVerb {
    /// Export the true and estimated trajectories for evo
    Tum(ExportTumArgs),
    /// Export all ticks as one table
    #[command(after_help = AFTER_CSV)]
    Csv(ExportTableArgs),
    /// Export all ticks and scans as one table for pandas, polars or DuckDB
    #[command(after_help = AFTER_PARQUET)]
    Parquet(ExportTableArgs),
    /// Export all ticks as ROS 2 messages in one MCAP file
    Mcap(ExportMcapArgs),
    /// Export all ticks as a rosbag2 folder for ros2 bag play
    Rosbag(ExportRosbagArgs),
    /// Export the scenario with the driver's commands as a script
    Scenario(ExportScenarioArgs),
}

#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_SCENARIO)]
pub struct ExportScenarioArgs {
    /// Log to read
    pub log: PathBuf,
    /// Folder to write to [default: scenario, next to the log]
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub path: Option<PathBuf>,
    /// Replace existing files
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_TUM)]
pub struct ExportTumArgs {
    /// Log to read
    pub log: PathBuf,
    /// Folder to write to [default: tum, next to the log]
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub path: Option<PathBuf>,
    /// Also write estimates of ticks without a true pose
    #[arg(long)]
    pub all: bool,
    /// Replace existing files
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Args, Clone, Debug)]
pub struct ExportTableArgs {
    /// Log to read
    pub log: PathBuf,
    /// File to write [default: LOG with the extension of the format]
    #[arg(short = 'o', long = "output", value_name = "FILE")]
    pub path: Option<PathBuf>,
    /// Replace an existing file
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_ROS)]
pub struct ExportMcapArgs {
    /// Log to read
    pub log: PathBuf,
    /// File to write [default: LOG with the extension .mcap]
    #[arg(short = 'o', long = "output", value_name = "FILE")]
    pub path: Option<PathBuf>,
    #[command(flatten)]
    pub ros: RosArgs,
}

#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_ROS)]
pub struct ExportRosbagArgs {
    /// Log to read
    pub log: PathBuf,
    /// Folder to write [default: rosbag, next to the log]
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub path: Option<PathBuf>,
    #[command(flatten)]
    pub ros: RosArgs,
}

#[derive(Args, Clone, Debug)]
pub struct RosArgs {
    /// Participant that moves odom in map, or none
    #[arg(long, value_name = "NAME")]
    pub estimator: Option<String>,
    /// Also write the true poses
    #[arg(long)]
    pub truth: bool,
    /// Replace an existing file or bag
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub output: Output,
}

impl RosArgs {
    fn options(&self) -> RosOptions {
        let Self { estimator, truth, force, .. } = self.clone();
        RosOptions { estimator, truth, force }
    }
}

pub fn run(args: &ExportArgs) -> Result<Exit> {
    let stop = stop_flag()?;
    let (exported, output, wants_truth) = match &args.what {
        ExportVerb::Tum(args) => {
            let folder = args.path.clone().unwrap_or_else(|| args.log.with_file_name("tum"));
            let tum = Tum { all: args.all, force: args.force };
            (tum.export(&args.log, &folder, &stop)?, args.output, true)
        }
        ExportVerb::Csv(args) => {
            let out = args.path.clone().unwrap_or_else(|| args.log.with_extension("csv"));
            check_apart([&args.log], [&out])?;
            (csv::export(&args.log, &out, args.force, &stop)?, args.output, false)
        }
        ExportVerb::Parquet(args) => {
            let out = args.path.clone().unwrap_or_else(|| args.log.with_extension("parquet"));
            check_apart([&args.log], [&out])?;
            (parquet::export(&args.log, &out, args.force, &stop)?, args.output, false)
        }
        ExportVerb::Scenario(args) => return export_scenario(args, &stop),
        ExportVerb::Mcap(ExportMcapArgs { log, path, ros }) => {
            let out = path.clone().unwrap_or_else(|| log.with_extension("mcap"));
            check_apart([log], [&out])?;
            return Ok(print_ros(&mcap::export(log, &out, &ros.options(), &stop)?, ros.output));
        }
        ExportVerb::Rosbag(ExportRosbagArgs { log, path, ros }) => {
            let out = path.clone().unwrap_or_else(|| log.with_file_name("rosbag"));
            return Ok(print_ros(&rosbag::export(log, &out, &ros.options(), &stop)?, ros.output));
        }
    };
    report_problems(&exported, wants_truth);
    output.print_with(&exported, || print(&exported, wants_truth));
    Ok(if exported.walked.is_whole() { Exit::Done } else { Exit::Lost })
}

fn export_scenario(args: &ExportScenarioArgs, stop: &AtomicBool) -> Result<Exit> {
    let folder = args.path.clone().unwrap_or_else(|| args.log.with_file_name("scenario"));
    let exported = scenario::export(&args.log, &folder, args.force, stop)?;
    if let Some(cut) = &exported.walked.cut {
        errln!("{}: {cut}; its complete ticks are exported", exported.log);
    }
    args.output.print_with(&exported, || {
        outln!("ticks     {}", exported.walked.ticks);
        for name in &exported.drivers {
            outln!("driver    {name}: its commands are the script");
        }
        exported.files.iter().for_each(|path| outln!("written   {path}"));
        outln!("run       sim-server launch {}", shell::quoted(&exported.files[0]));
    });
    Ok(if exported.walked.is_whole() { Exit::Done } else { Exit::Lost })
}

fn print_ros(exported: &RosExported, output: Output) -> Exit {
    report_losses(&exported.log, &exported.walked);
    output.print_with(exported, || {
        let mut table = TextTable::new("topic  type  >messages");
        for topic in &exported.topics {
            table.row(&[&topic.name, &topic.type_name, &topic.messages]);
        }
        outln!("{table}");
        exported.findings.iter().for_each(|finding| outln!("finding   {finding}"));
        outln!("ticks     {}", exported.walked.ticks);
        outln!("written   {} ({} messages)", exported.path, exported.messages());
    });
    if exported.walked.is_whole() { Exit::Done } else { Exit::Lost }
}

fn report_losses(log: &str, walked: &Walked) {
    if let Some(cut) = &walked.cut {
        errln!("{log}: {cut}; its complete ticks are exported");
    }
    if walked.damaged_records > 0 {
        let damaged = walked.damaged_records;
        errln!("{log}: the checksums of {damaged} records fail; their values are suspect");
    }
}

fn report_problems(exported: &Exported, wants_truth: bool) {
    let log = &exported.log;
    if wants_truth && exported.ticks_with_truth == 0 {
        errln!("{log}: no tick has a known true pose: the estimates are written, no truth.tum");
    }
    for name in &exported.without {
        errln!("{log}: {name} answered no pose that can be written");
    }
    report_losses(log, &exported.walked);
    let StampOrder { stamps_repeated: repeated, stamps_backwards: backwards, .. } = exported.stamps;
    if wants_truth && repeated > 0 {
        errln!(
            "{log}: {repeated} ticks have the stamp of the tick before, and evo confuses poses of \
             one stamp; import the recording again, or measure with `score --log {log}`"
        );
    }
    if wants_truth && backwards > 0 {
        errln!("{log}: {backwards} ticks have an earlier stamp than the tick before");
    }
}

fn print(exported: &Exported, wants_truth: bool) {
    let ticks = exported.walked.ticks;
    outln!("ticks     {ticks}, {} with a known truth", exported.ticks_with_truth);
    for file in &exported.files {
        outln!("written   {} ({} lines)", file.path, file.lines);
    }
    let of = |is: fn(Option<&str>) -> bool| {
        exported.files.iter().find(|f| is(f.estimator.as_deref())).map(|f| &f.path)
    };
    if let (true, Some(truth), Some(estimate)) = (
        wants_truth && exported.stamps.stamps_repeated == 0,
        of(|e| e.is_none()),
        of(|e| e.is_some()),
    ) {
        outln!("measure   evo_ape tum {truth} {estimate}");
    }
}
