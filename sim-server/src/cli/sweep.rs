//! What `sweep` takes.

use std::path::PathBuf;

use clap::Args;

use rusty_study::sweep::{Seeds, Shard};

const AFTER_HELP: &str = "\
Without --clients, nobody takes part but dead reckoning, inside this process, at
the speed of the world: rows and digests are those of `launch --seed N` with
dead-reckoning as the one estimator, to the bit. With --clients, every run is a
whole launch of the scenario with its programs, and each estimator has a row, with
more of the scorer's figures: aligned and relative errors, NEES, NIS, convergence,
recovery, compute times. The report then says whose covariances are right: the mean
over the seeds of the last tick's normalised squared error (ANEES) is about 3.

Rows come in the order of the settings (the last --set changes fastest), then of
the seeds, whatever --jobs is. Angles are in rad, lengths in m. FILE.csv has the
settings beside it in FILE.csv.json, FILE.parquet in its metadata (rusty.*).

A list of values is split at commas outside [], {} and quotation marks:
  --set 'start={ x_m = 6.0, y_m = 4.5, theta_rad = 0.0 },{ x_m = 5.0, y_m = 4.5, theta_rad = 0.0 }'

Ctrl-C keeps what is done in FILE.part (exit code 3); --resume goes on there and
comes to the same bytes (of a sweep with --clients all but the compute_* columns,
which are the machine's). A file that is complete is left as it is.

Parts for many machines, numbered from 0; the parts' rows, one part after the
other, are those of the whole:
  Slurm, #SBATCH --array=0-15:
    sim-server sweep patrol --seeds 0..100000 --resume \\
      --shard $SLURM_ARRAY_TASK_ID/16 --out part-$SLURM_ARRAY_TASK_ID.parquet
  Kubernetes, a Job with completionMode: Indexed and completions: 16:
    sim-server sweep patrol --seeds 0..100000 --resume \\
      --shard $JOB_COMPLETION_INDEX/16 --out /data/part-$JOB_COMPLETION_INDEX.parquet

Examples:
  sim-server sweep patrol --seeds 0..500                     the chapter's table
  sim-server sweep patrol --seeds 0..500 --set robot.slip_std=0.01,0.02,0.04 --out slip.csv
  sim-server sweep apartment --seeds 0..20 --clients --jobs 2 --out apartment.parquet
  sim-server sweep apartment --seeds 0..20 --clients --add ekf=ekf    another estimator";

/// `sweep`.
#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_HELP)]
pub struct SweepArgs {
    /// A scenario file, or one of: apartment, patrol, figure-eight, hallway, driver
    #[arg(default_value = "apartment")]
    pub scenario: String,
    /// Seeds: A..B without B, A..=B with it, or one
    #[arg(long, value_name = "A..B")]
    pub seeds: Seeds,
    /// Change a field, or sweep it: all combinations of all lists are run
    #[arg(long = "set", value_name = "KEY=V1[,V2…]")]
    pub changes: Vec<String>,
    /// Sweep a field over two values that share every seed: paired differences
    #[arg(long, value_name = "KEY=V1,V2")]
    pub ab: Option<String>,
    /// Number of ticks [default: the scenario's]
    #[arg(long)]
    pub ticks: Option<u64>,
    /// Runs at a time [default: one for each processor]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// The table to write: FILE.parquet or FILE.csv [default: none]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Go on with what an interrupted sweep left beside FILE
    #[arg(long, requires = "out")]
    pub resume: bool,
    /// Replace FILE, and what an interrupted sweep left beside it
    #[arg(long, requires = "out", conflicts_with = "resume")]
    pub force: bool,
    /// Make one part of n alone, i from 0
    #[arg(long, value_name = "i/n", default_value_t = Shard::WHOLE, hide_default_value = true)]
    pub shard: Shard,
    /// Whole runs with the scenario's programs, as `launch` makes them
    #[arg(long)]
    pub clients: bool,
    /// Add an estimator to every run, as launch does
    #[arg(long, value_name = "NAME=COMMAND", requires = "clients")]
    pub add: Vec<String>,
    /// Keep the runs' folders (logs, scores, pictures) in this one
    #[arg(long, value_name = "DIR", requires = "clients")]
    pub runs: Option<PathBuf>,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
    /// Show no progress
    #[arg(long, short)]
    pub quiet: bool,
}
