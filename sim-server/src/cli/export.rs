//! What `export` takes.

use std::path::PathBuf;

use clap::{Args, Subcommand};

const AFTER_TUM: &str = "\
A line is a pose: timestamp tx ty tz qx qy qz qw, in s and m, z and the first two
parts of the quaternion 0. Numbers are as short as they can be and still read back
to the same bits.

truth.tum has every tick with a known true pose, NAME.tum the ticks of an
estimator that `score` scores: those with a true pose and an estimate in effect
(an answer whose compute time is modelled takes effect when that is over). So each
line of NAME.tum has its partner of the same timestamp, and evo measures what
score.json says (but where a recording's stamps repeat: evo pairs by time, and takes
the first of them):
  sim-server export tum runs/NAME/run.log -o tum
  evo_ape tum tum/truth.tum tum/dead-reckoning.tum
  evo_rpe tum tum/truth.tum tum/dead-reckoning.tum --delta 1 --delta_unit m

A log without any true pose (a blind one, say) has no truth.tum, and its estimates
are written all: said on stderr, exit code 0, for nothing of the log is lost. A
log that is cut or damaged is exported as far as it goes: exit code 3.";

const AFTER_CSV: &str = "\
A line per tick: tick, time_s, the encoder counts, the command, the true pose, and
of every participant that answers the pose in effect and the variances it reports
(the diagonal of its covariance: m², m², rad², in the frame of the estimate).
What there is not is left empty. Angles are in rad, in (-π, π].

  sim-server export csv runs/NAME/run.log -o run.csv";

/// `export`.
#[derive(Args, Clone, Debug)]
pub struct ExportArgs {
    /// As what
    #[command(subcommand)]
    pub what: ExportVerb,
}

/// What a log can be exported as.
#[derive(Subcommand, Clone, Debug)]
pub enum ExportVerb {
    /// Trajectories as evo reads them: truth.tum, and NAME.tum of every estimator
    Tum(ExportTumArgs),
    /// One table of all ticks: counts, command, truth, estimates, variances
    Csv(ExportCsvArgs),
}

/// `export tum`.
#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_TUM)]
pub struct ExportTumArgs {
    /// The log
    pub log: PathBuf,
    /// Folder to write to; made if it is not there [default: tum, beside the log]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Every estimate, also those of ticks without a known true pose
    #[arg(long)]
    pub all: bool,
    /// Replace files that are there
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
    /// The log
    pub log: PathBuf,
    /// File to write [default: the log's name with .csv, beside it]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Replace a file that is there
    #[arg(long)]
    pub force: bool,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}
