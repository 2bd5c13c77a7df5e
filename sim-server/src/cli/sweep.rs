//! The arguments of `sweep`.

use std::path::PathBuf;

use clap::Args;

use rusty_study::sweep::{Seeds, Shard};

const AFTER_HELP: &str = "\
Without --clients, dead reckoning is the only participant. It runs inside this
process, which is fastest; rows and digests are those of `launch --seed N` with
dead-reckoning as the only estimator, to the bit. With --clients, every run is a
complete launch of the scenario with its programs. Each estimator has a row with
further figures: aligned and relative errors, NEES, NIS, convergence, recovery,
compute times. The report then tests the covariances: the mean over the seeds of
the normalised squared error of the last tick (ANEES) is about 3 if they are right.

Rows are in the order of the settings (the last --set changes fastest), then of the
seeds, for any --jobs. Angles are in rad, lengths in m. The settings are kept in
FILE.csv.json, or in the metadata of FILE.parquet (rusty.*).

The lists of all --set are combined. A list is split at commas outside [], {} and
quotation marks:
  --set 'start={ x_m = 6.0, y_m = 4.5, theta_rad = 0.0 },{ x_m = 5.0, y_m = 4.5, theta_rad = 0.0 }'

Ctrl-C keeps the finished rows in FILE.part (exit code 3). --resume continues there
and writes the same bytes (with --clients except for the compute_* columns, which
depend on the machine). A complete file is left unchanged.

--shard splits a sweep for many machines. Its parts, numbered from 0, have together
the rows of the whole sweep in the same order:
  Slurm, #SBATCH --array=0-15:
    sim-server sweep patrol --seeds 0..100000 --resume \\
      --shard $SLURM_ARRAY_TASK_ID/16 --out part-$SLURM_ARRAY_TASK_ID.parquet
  Kubernetes, a Job with completionMode: Indexed and completions: 16:
    sim-server sweep patrol --seeds 0..100000 --resume \\
      --shard $JOB_COMPLETION_INDEX/16 --out /data/part-$JOB_COMPLETION_INDEX.parquet

Examples:
  sim-server sweep patrol --seeds 0..500                     the table of the chapter
  sim-server sweep patrol --seeds 0..500 --set robot.slip_std=0.01,0.02,0.04 --out slip.csv
  sim-server sweep apartment --seeds 0..20 --clients --jobs 2 --out apartment.parquet
  sim-server sweep apartment --seeds 0..20 --clients --add ekf=ekf    with the EKF";

/// `sweep`.
#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_HELP)]
pub struct SweepArgs {
    /// apartment, patrol, figure-eight, hallway, driver or a file
    #[arg(default_value = "apartment")]
    pub scenario: String,
    /// Seeds A..B (without B), A..=B (with B) or one seed
    #[arg(long, value_name = "A..B")]
    pub seeds: Seeds,
    /// Change a field, or sweep it over a list of values
    #[arg(long = "set", value_name = "KEY=V1[,V2…]")]
    pub changes: Vec<String>,
    /// Compare two values of a field on the same seeds
    #[arg(long, value_name = "KEY=V1,V2")]
    pub ab: Option<String>,
    /// Number of ticks [default: the scenario's]
    #[arg(long)]
    pub ticks: Option<u64>,
    /// Number of parallel runs [default: one per processor]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// Table to write, FILE.parquet or FILE.csv [default: none]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Continue an interrupted sweep from FILE.part
    #[arg(long, requires = "out")]
    pub resume: bool,
    /// Replace FILE and the remains of an interrupted sweep
    #[arg(long, requires = "out", conflicts_with = "resume")]
    pub force: bool,
    /// Run only part i of n, with i counted from 0
    #[arg(long, value_name = "i/n", default_value_t = Shard::WHOLE, hide_default_value = true)]
    pub shard: Shard,
    /// Launch complete runs with the programs of the scenario
    #[arg(long)]
    pub clients: bool,
    /// Add an estimator to every run
    #[arg(long, value_name = "NAME=COMMAND", requires = "clients")]
    pub add: Vec<String>,
    /// Keep the folders of the runs in this folder
    #[arg(long, value_name = "DIR", requires = "clients")]
    pub runs: Option<PathBuf>,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
    /// Show no progress
    #[arg(long, short)]
    pub quiet: bool,
}
