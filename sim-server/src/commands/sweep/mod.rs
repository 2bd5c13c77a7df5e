//! `sweep`: run a scenario with many seeds and settings, a row per run.

mod shards;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Context as _, Result};
use clap::{ArgGroup, Args, Subcommand};
use rusty_bench::machine::cores;
use rusty_contract::{Exit, errln, outln};
use rusty_engine::remarks::remarks;
use rusty_engine::run::Progress;
use rusty_study::sweep::job::journal_of;
use rusty_study::sweep::report::{Report, results};
use rusty_study::sweep::{Plan, Request, Seeds, SweepJob, SweepOutcome, Table, axes};
use serde::Serialize;
use signal_hook::consts::{SIGINT, SIGTERM};

use super::arguments::{Output, check_apart, check_writable};
use super::{WRITER, WrongUsage};

const AFTER_HELP: &str = "\
Without --clients, dead reckoning is the only participant. It runs inside this
process, which is fastest; rows and digests are those of `launch --seed N` with
dead-reckoning as the only estimator, to the bit. With --clients, the programs of
the scenario take part. Their processes stay for many runs, with the rows of separate
launches; one that carries state over is named (exit code 4). With --runs, every run is
a complete launch with report. Each estimator has a row with
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

`sweep plan` splits a sweep into shards for many processes or machines, `sweep run`
makes one, and `sweep merge` writes the table, which has the same bytes.

Examples:
  sim-server sweep patrol --seeds 0..500                     the table of the chapter
  sim-server sweep patrol --seeds 0..500 --set robot.slip_std=0.01,0.02,0.04 --out slip.csv
  sim-server sweep apartment --seeds 0..20 --clients --jobs 2 --out apartment.parquet
  sim-server sweep apartment --seeds 0..20 --clients --add ekf=ekf    with the EKF";

#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_HELP)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
#[command(group = ArgGroup::new("kept").args(["out", "runs"]).multiple(true))]
pub struct SweepArgs {
    #[command(subcommand)]
    pub step: Option<Step>,
    #[command(flatten)]
    pub what: WhatArgs,
    /// Number of parallel runs [default: one per processor]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// Table to write, FILE.parquet or FILE.csv [default: none]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Continue an interrupted sweep from FILE.part
    #[arg(long, requires = "out")]
    pub resume: bool,
    /// Replace FILE, its drawings, the remains of an interrupted sweep, and folders of runs
    #[arg(long, requires = "kept", conflicts_with = "resume")]
    pub force: bool,
    /// Keep the folders of the runs in this folder
    #[arg(long, value_name = "DIR", requires = "clients")]
    pub runs: Option<PathBuf>,
    #[command(flatten)]
    pub output: Output,
    /// Show no progress
    #[arg(long, short)]
    pub quiet: bool,
}

/// The steps of a sweep in shards.
#[derive(Subcommand, Clone, Debug)]
pub enum Step {
    /// Write the manifest of a sweep in shards
    Plan(shards::PlanArgs),
    /// Make the runs of one shard
    Run(shards::RunArgs),
    /// Write the table from the parts of all shards
    Merge(shards::MergeArgs),
}

/// The runs of a sweep.
#[derive(Args, Clone, Debug)]
pub struct WhatArgs {
    /// Built-in (apartment, patrol, office, …) or a file
    #[arg(default_value = "apartment")]
    pub scenario: String,
    /// Seeds A..B (without B), A..=B (with B) or one seed
    #[arg(long, value_name = "A..B", required = true)]
    pub seeds: Option<Seeds>,
    /// Change a field, or sweep it over a list of values
    #[arg(long = "set", value_name = "KEY=V1[,V2…]")]
    pub changes: Vec<String>,
    /// Compare two values of a field on the same seeds
    #[arg(long, value_name = "KEY=V1,V2")]
    pub ab: Option<String>,
    /// Number of ticks [default: the scenario's]
    #[arg(long)]
    pub ticks: Option<u64>,
    /// Launch complete runs with the programs of the scenario
    #[arg(long)]
    pub clients: bool,
    /// Add an estimator to every run
    #[arg(long, value_name = "NAME=COMMAND", requires = "clients")]
    pub add: Vec<String>,
}

impl WhatArgs {
    /// Loads the scenario, and checks what can be checked before the first run.
    fn plan(&self) -> Result<Plan> {
        let seeds = self.seeds.ok_or_else(|| WrongUsage("give --seeds A..B".to_owned()))?;
        let request = Request {
            scenario: self.scenario.clone(),
            seeds,
            axes: axes(&self.changes, self.ab.as_deref())?,
            ticks: self.ticks,
            clients: self.clients,
            add: self.add.clone(),
        };
        let plan = Plan::new(request)?;
        let roster = |cell: usize| plan.rosters.get(cell).map_or(&[][..], Vec::as_slice);
        let cells = plan.cells.iter().enumerate();
        let all: BTreeSet<String> =
            cells.flat_map(|(i, cell)| remarks(&cell.config, roster(i))).collect();
        all.iter().for_each(|remark| errln!("{remark}"));
        Ok(plan)
    }
}

pub fn run(args: &SweepArgs) -> Result<Exit> {
    match &args.step {
        None => whole(args),
        Some(Step::Plan(args)) => shards::plan(args),
        Some(Step::Run(args)) => shards::run(args),
        Some(Step::Merge(args)) => shards::merge(args),
    }
}

/// A sweep in one process.
fn whole(args: &SweepArgs) -> Result<Exit> {
    let plan = args.what.plan()?;
    let table = args.out.as_deref().map(Table::at).transpose()?;
    let written: Vec<PathBuf> =
        table.iter().flat_map(|table| results(table).chain([journal_of(table)])).collect();
    check_apart(&plan.files, &written)?;
    args.out.iter().filter(|path| !path.exists()).try_for_each(|path| check_writable(path))?;
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
    let stop = stop_flag()?;
    let progress = Progress::new(ticks, args.quiet || args.output.json);
    let came = sweeping.run(&stop, progress)?;
    let complete = came.runs == came.planned && !came.was_complete;
    let report = complete.then(|| Report::of(&came.swept, args.what.ab.is_some()));
    Ok(print(args, &came, report))
}

/// Returns a flag that Ctrl-C and SIGTERM raise. A second signal ends the process; the
/// journal has what is done.
fn stop_flag() -> Result<Arc<AtomicBool>> {
    let stop = Arc::<AtomicBool>::default();
    for signal in [SIGINT, SIGTERM] {
        let code = Exit::Lost as i32;
        signal_hook::flag::register_conditional_shutdown(signal, code, Arc::clone(&stop))
            .and_then(|_| signal_hook::flag::register(signal, Arc::clone(&stop)))
            .context("signals")?;
    }
    Ok(stop)
}

/// The document of `--json`.
#[derive(Serialize)]
struct Document<'a> {
    scenario: &'a str,
    seeds: String,
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

fn print(args: &SweepArgs, came: &SweepOutcome, report: Option<Report>) -> Exit {
    let interrupted = came.runs < came.planned;
    let shown = |path: &Path| path.display().to_string();
    let per_s = if came.elapsed_s > 0.0 { came.ticks as f64 / came.elapsed_s } else { 0.0 };
    let document = Document {
        scenario: &args.what.scenario,
        seeds: args.what.seeds.map_or_else(String::new, |s| s.to_string()),
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
        pictures: came.pictures.iter().map(|p| shown(p)).collect(),
        lost: &came.lost,
        report,
    };
    args.output.print_with(&document, || {
        document.report.iter().for_each(|report| outln!("{report}"));
    });
    let seconds = came.elapsed_s;
    if came.was_complete {
        came.lost.iter().for_each(|(seed, lost)| errln!("seed {seed}: {lost}"));
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
        args.out.iter().chain(&came.pictures).for_each(|path| outln!("{}", path.display()));
    }
    if interrupted || !came.lost.is_empty() { Exit::Lost } else { Exit::Done }
}
