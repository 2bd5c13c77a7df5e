//! The arguments of `export`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

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
  evo_rpe tum tum/truth.tum tum/dead-reckoning.tum --delta 1 --delta_unit m

A log without true poses (e.g. a blind log) has no truth.tum, and all its estimates
are written. This is reported on stderr; the exit code is 0, because nothing of
the log is lost. Of a truncated or damaged log the readable part is exported; the
exit code is 3.";

const AFTER_CSV: &str = "\
A line per tick has tick, time_s, the encoder counts, the command, the true pose,
and for every participant that answers, the pose in effect and its reported
variances (the diagonal of the covariance in m², m², rad², in the frame of the
estimate). Missing values are empty. Angles are in rad, in (-π, π].

  sim-server export csv runs/NAME/run.log -o run.csv";

/// `export`.
#[derive(Args, Clone, Debug)]
pub struct ExportArgs {
    /// Output format
    #[command(subcommand)]
    pub what: ExportVerb,
}

/// The output formats.
#[derive(Subcommand, Clone, Debug)]
pub enum ExportVerb {
    /// Export the true and estimated trajectories for evo
    Tum(ExportTumArgs),
    /// Export all ticks as one table
    Csv(ExportCsvArgs),
}

/// `export tum`.
#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_TUM)]
pub struct ExportTumArgs {
    /// Log to read
    pub log: PathBuf,
    /// Folder to write to [default: tum, next to the log]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Also write estimates of ticks without a true pose
    #[arg(long)]
    pub all: bool,
    /// Replace existing files
    #[arg(long)]
    pub force: bool,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// `export csv`.
#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_CSV)]
pub struct ExportCsvArgs {
    /// Log to read
    pub log: PathBuf,
    /// File to write [default: LOG with the extension .csv]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Replace an existing file
    #[arg(long)]
    pub force: bool,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}
