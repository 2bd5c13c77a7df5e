//! `sweep`: run a scenario with many seeds and settings, a row per run.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Context as _, Result};
use clap::Args;
use rusty_bench::machine::cores;
use rusty_contract::{Exit, FieldError, errln, outln};
use rusty_engine::run::Progress;
use rusty_study::sweep::report::{Report, draw};
use rusty_study::sweep::{Axis, Plan, Request, Seeds, Shard, SweepJob, SweepOutcome, Table};
use serde::Serialize;
use signal_hook::consts::{SIGINT, SIGTERM};

use super::WRITER;
use super::arguments::Output;

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

#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_HELP)]
pub struct SweepArgs {
    /// apartment, patrol, hallway, driver, glass-lobby, … or a file
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
    #[command(flatten)]
    pub output: Output,
    /// Show no progress
    #[arg(long, short)]
    pub quiet: bool,
}

pub fn run(args: &SweepArgs) -> Result<Exit> {
    let plan = Plan::new(Request {
        scenario: args.scenario.clone(),
        seeds: args.seeds,
        axes: axes(args)?,
        ticks: args.ticks,
        shard: args.shard,
        clients: args.clients,
        add: args.add.clone(),
    })?;
    let table = args.out.as_deref().map(Table::at).transpose()?;
    let ticks = plan.runs.clone().map(|run| plan.ticks(run)).sum();
    let sweeping = SweepJob {
        plan,
        writer: WRITER.to_owned(),
        jobs: args.jobs.map_or_else(cores, usize::from),
        table,
        resume: args.resume,
        force: args.force,
        runs_dir: args.runs.clone(),
    };
    let stop = Arc::<AtomicBool>::default();
    for signal in [SIGINT, SIGTERM] {
        // A second signal ends the process; the journal has what is done.
        let code = Exit::Lost as i32;
        signal_hook::flag::register_conditional_shutdown(signal, code, Arc::clone(&stop))
            .and_then(|_| signal_hook::flag::register(signal, Arc::clone(&stop)))
            .context("signals")?;
    }
    let progress = Progress::new(ticks, args.quiet || args.output.json);
    let came = sweeping.run(&stop, progress)?;
    let complete = came.runs == came.planned && !came.was_complete;
    let report = complete.then(|| Report::of(&came.swept, args.ab.is_some()));
    let pictures = match &args.out {
        Some(out) if complete => draw(&came.swept, out)?,
        _ => Vec::new(),
    };
    Ok(print(args, &came, report, &pictures))
}

/// The swept fields: every `--set`, then `--ab`.
fn axes(args: &SweepArgs) -> Result<Vec<Axis>, FieldError> {
    let axes = args.changes.iter().map(|text| Axis::parse("--set", text));
    let mut axes: Vec<Axis> = axes.collect::<Result<_, _>>()?;
    if let Some(text) = &args.ab {
        let axis = Axis::parse("--ab", text)?;
        if axis.values.len() != 2 {
            let problem = format!("has {} values", axis.values.len());
            let remedy = "give the two to compare: --ab robot.slip_std=0.02,0.03";
            return Err(FieldError::new("--ab", text, problem, remedy));
        }
        axes.push(axis);
    }
    Ok(axes)
}

/// The document of `--json`.
#[derive(Serialize)]
struct Document<'a> {
    scenario: &'a str,
    seeds: String,
    shard: String,
    /// The swept fields of each cell.
    cells: Vec<&'a [(String, String)]>,
    /// Runs whose rows are in the table.
    runs: u64,
    runs_planned: u64,
    /// Runs that an earlier sweep had done.
    runs_resumed: u64,
    ticks: u64,
    elapsed_s: f64,
    ticks_per_s: f64,
    /// Whether it was stopped before the last run.
    interrupted: bool,
    /// The table; null while it is not complete, or none was asked for.
    table: Option<String>,
    /// The finished runs of an interrupted sweep.
    journal: Option<String>,
    pictures: Vec<String>,
    /// Runs in which something was lost: seed and what.
    lost: &'a [(u64, String)],
    /// Null if rows are missing, or if none was missing at the start.
    report: Option<Report>,
}

fn print(
    args: &SweepArgs,
    came: &SweepOutcome,
    report: Option<Report>,
    pictures: &[PathBuf],
) -> Exit {
    let interrupted = came.runs < came.planned;
    let shown = |path: &Path| path.display().to_string();
    let per_s = if came.elapsed_s > 0.0 { came.ticks as f64 / came.elapsed_s } else { 0.0 };
    let document = Document {
        scenario: &args.scenario,
        seeds: args.seeds.to_string(),
        shard: args.shard.to_string(),
        cells: came.swept.cells.iter().map(|c| &*c.parameters).collect(),
        runs: came.runs,
        runs_planned: came.planned,
        runs_resumed: came.resumed,
        ticks: came.ticks,
        elapsed_s: came.elapsed_s,
        ticks_per_s: per_s,
        interrupted,
        table: args.out.as_deref().filter(|_| !interrupted).map(shown),
        journal: came.journal.as_deref().map(shown),
        pictures: pictures.iter().map(|p| shown(p)).collect(),
        lost: &came.lost,
        report,
    };
    args.output.print_with(&document, || {
        document.report.iter().for_each(|report| outln!("{report}"));
    });
    let seconds = came.elapsed_s;
    if came.was_complete {
        errln!("{}: complete already", args.out.as_deref().map(shown).unwrap_or_default());
    } else {
        let rate = format!("{} ticks in {seconds:.3} s, {per_s:.0} per second", came.ticks);
        errln!("{} of {} runs ({} done before) · {rate}", came.runs, came.planned, came.resumed);
    }
    if interrupted {
        match &came.journal {
            Some(path) => errln!("what is done is in {}: go on with --resume", path.display()),
            None => errln!("nothing is kept without --out FILE"),
        }
    } else if !args.output.json {
        args.out.iter().chain(pictures).for_each(|path| outln!("{}", path.display()));
    }
    if interrupted || !came.lost.is_empty() { Exit::Lost } else { Exit::Done }
}
