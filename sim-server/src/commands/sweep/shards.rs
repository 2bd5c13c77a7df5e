//! `sweep plan`, `run` and `merge`: a sweep on many processes or machines.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use rusty_contract::output::make_folder;
use rusty_contract::{Exit, FieldError, errln, outln};
use rusty_engine::run::Progress;
use rusty_study::sweep::report::{Report, draw, results};
use rusty_study::sweep::{
    Manifest, PartFault, Plan, SweepError, SweepJob, Table, merge as merge_parts, run_time_s,
};
use serde::Serialize;

use super::super::WRITER;
use super::super::arguments::{Output, check_apart, check_free, check_writable};
use super::{WhatArgs, stop_flag};

/// Time that a shard takes on one core, s.
const SHARD_S: f64 = 60.0;

const PLAN_HELP: &str = "\
The manifest has the options of the sweep, all settings, the number of shards, and the
digests of the golden runs of this build (`sim-server doctor`). A pilot of up to 200 runs
gives the number of shards, so that each takes about 60 s on one core. The same options
and the same --shards N give the same manifest.

Scenarios, worlds and programs that are files are not part of it: every machine needs
them under the same path, and a difference is an error.

Examples:
  sim-server sweep plan patrol --seeds 0..100000 -o slip.toml
  sim-server sweep run slip.toml --shard 0
  sim-server sweep merge slip.toml --out slip.parquet";

const RUN_HELP: &str = "\
The part is complete or not there: it is written under another name and renamed. A part
that is complete is left unchanged (exit code 0); one that is damaged is made again.
So a scheduler may start a shard any number of times, also at the same time.
Nothing is drawn.

The machine must make the settings of the manifest and must compute the golden runs to
the bit (exit code 4).

Slurm, a script for `sbatch --array=0-15 --requeue`:
  sim-server sweep run slip.toml --shard $SLURM_ARRAY_TASK_ID
Kubernetes, a Job with completionMode: Indexed and completions: 16:
  sim-server sweep run slip.toml --shard $JOB_COMPLETION_INDEX --out /data
Python: rusty.sweep(\"slip.toml\", engine=\"local\"), \"ray\" or \"slurm\".";

const MERGE_HELP: &str = "\
Table, report and drawings are those of `sweep` with the options of the manifest: the
same bytes (with clients except for the compute_* columns). If a part is missing or
damaged, nothing is written, and the message has the command that makes it. --json then
prints the indices of the shards as `missing`.";

#[derive(Args, Clone, Debug)]
#[command(after_help = PLAN_HELP)]
pub struct PlanArgs {
    #[command(flatten)]
    what: WhatArgs,
    /// Manifest to write
    #[arg(short = 'o', long = "output", value_name = "M.toml")]
    output_file: PathBuf,
    /// Number of shards [default: 60 s each, from a pilot]
    #[arg(long, value_name = "N")]
    shards: Option<u64>,
    /// Replace the manifest
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    output: Output,
}

#[derive(Args, Clone, Debug)]
#[command(after_help = RUN_HELP)]
pub struct RunArgs {
    /// Manifest from `sweep plan`
    #[arg(value_name = "M.toml")]
    manifest: PathBuf,
    /// Index of the shard, from 0
    #[arg(long, value_name = "I")]
    shard: u64,
    /// Folder of the parts [default: M.parts]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of parallel runs
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    jobs: u16,
    #[command(flatten)]
    output: Output,
    /// Show no progress
    #[arg(long, short)]
    quiet: bool,
}

#[derive(Args, Clone, Debug)]
#[command(after_help = MERGE_HELP)]
pub struct MergeArgs {
    /// Manifest from `sweep plan`
    #[arg(value_name = "M.toml")]
    manifest: PathBuf,
    /// Folder of the parts [default: M.parts]
    #[arg(value_name = "DIR")]
    parts: Option<PathBuf>,
    /// Table to write, FILE.parquet or FILE.csv [default: none]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replace FILE
    #[arg(long, requires = "out")]
    force: bool,
    #[command(flatten)]
    output: Output,
}

/// The document of `sweep plan --json`.
#[derive(Serialize)]
struct Planned<'a> {
    manifest: &'a Path,
    digest: &'a str,
    shards: u64,
    runs: u64,
    /// Mean time of a run on one core, s; null without a pilot.
    run_s: Option<f64>,
}

pub fn plan(args: &PlanArgs) -> Result<Exit> {
    check_free(&args.output_file, args.force)?;
    check_writable(&args.output_file)?;
    if folder(None, &args.output_file) == args.output_file {
        let remedy = "give it another ending, e.g. .toml";
        let problem = "has the name of the folder of its parts";
        return Err(FieldError::new("-o", args.output_file.display(), problem, remedy).into());
    }
    let plan = args.what.plan()?;
    check_apart(&plan.files, [&args.output_file])?;
    let job = job(plan, 1);
    let run_s = match args.shards {
        Some(_) => None,
        None => {
            let stop = stop_flag()?;
            errln!("measuring the time of a run");
            let Some(run_s) = run_time_s(&job, &stop)? else { return Ok(Exit::Lost) };
            Some(run_s)
        }
    };
    let runs = job.plan.count();
    let shards = args.shards.unwrap_or_else(|| shards(runs, run_s.unwrap_or(0.0)));
    let manifest = Manifest::of(&job.plan, args.what.ab.is_some(), shards, WRITER)?;
    manifest.write(&args.output_file)?;
    let path = &*args.output_file;
    let planned = Planned { manifest: path, digest: &manifest.digest, shards, runs, run_s };
    args.output.print_with(&planned, || {
        outln!("{}", path.display());
        let per_shard = runs.div_ceil(shards);
        errln!("{shards} shards of up to {per_shard} runs");
        if let Some(run_s) = run_s {
            let shard_s = run_s * per_shard as f64;
            errln!("{:.3} ms for a run, {shard_s:.0} s for a shard on one core", run_s * 1e3);
        }
    });
    Ok(Exit::Done)
}

/// Number of shards of 60 s for runs of `run_s` seconds.
fn shards(runs: u64, run_s: f64) -> u64 {
    let shards = (runs as f64 * run_s / SHARD_S).ceil();
    (shards as u64).clamp(1, runs.max(1))
}

fn job(plan: Plan, jobs: usize) -> SweepJob {
    SweepJob {
        plan,
        writer: WRITER.to_owned(),
        jobs,
        table: None,
        resume: false,
        force: false,
        runs_dir: None,
    }
}

/// Returns the folder of the parts: next to the manifest unless given.
fn folder(given: Option<&Path>, manifest: &Path) -> PathBuf {
    given.map_or_else(|| manifest.with_extension("parts"), Path::to_owned)
}

/// The document of `sweep run --json`.
#[derive(Serialize)]
struct MadePart<'a> {
    part: &'a Path,
    shard: u64,
    shards: u64,
    runs: u64,
    /// Whether the part was complete before.
    was_complete: bool,
    ticks: u64,
    elapsed_s: f64,
}

pub fn run(args: &RunArgs) -> Result<Exit> {
    let manifest = Manifest::read(&args.manifest)?;
    let folder = folder(args.out.as_deref(), &args.manifest);
    let part = manifest.part(&folder, args.shard)?;
    let shards = manifest.shards;
    let runs = part.runs.end - part.runs.start;
    let show = |was_complete, ticks, elapsed_s| {
        let (part, shard) = (&*part.path, args.shard);
        let made = MadePart { part, shard, shards, runs, was_complete, ticks, elapsed_s };
        args.output.print_with(&made, || outln!("{}", part.display()));
    };
    match part.read() {
        Ok(_) => {
            errln!("{}: complete already", part.path.display());
            show(true, 0, 0.0);
            return Ok(Exit::Done);
        }
        Err(PartFault::Missing) => {}
        Err(fault) => errln!("{} {fault}: it is made again", part.path.display()),
    }
    let (whole, _) = manifest.plan(WRITER)?;
    manifest.check_goldens()?;
    // Before anything is on disk: who sees the folder may interrupt the shard.
    let stop = stop_flag()?;
    make_folder(&folder).map_err(SweepError::io(&folder))?;
    let job = job(whole.of_shard(part.shard()), usize::from(args.jobs));
    let ticks = job.plan.runs.clone().map(|run| job.plan.ticks(run)).sum();
    let progress = Progress::new(ticks, args.quiet || args.output.json);
    let made = job.records(None, Vec::new(), &stop, progress)?;
    if made.records.len() as u64 != runs {
        let done = made.records.len();
        errln!("interrupted after {done} of {runs} runs: no part is written; run the shard again");
        return Ok(Exit::Lost);
    }
    part.write(&made.records)?;
    let (ticks, seconds) = (made.ticks, made.elapsed_s);
    errln!("shard {} of {shards}: {runs} runs, {ticks} ticks in {seconds:.3} s", args.shard);
    show(false, ticks, seconds);
    Ok(Exit::Done)
}

/// The document of `sweep merge --json`.
#[derive(Serialize)]
struct MergedDocument {
    shards: u64,
    runs: u64,
    /// Indices of the shards that have no complete part.
    missing: Vec<u64>,
    table: Option<PathBuf>,
    pictures: Vec<PathBuf>,
    /// Runs in which something was lost: seed and what.
    lost: Vec<(u64, String)>,
    /// Null if a part is missing.
    report: Option<Report>,
}

pub fn merge(args: &MergeArgs) -> Result<Exit> {
    let manifest = Manifest::read(&args.manifest)?;
    let table = args.out.as_deref().map(Table::at).transpose()?;
    let written: Vec<PathBuf> = table.iter().flat_map(results).collect();
    written.iter().try_for_each(|file| check_free(file, args.force))?;
    let (plan, settings) = manifest.plan(WRITER)?;
    check_apart(std::iter::once(&args.manifest).chain(&plan.files), &written)?;
    let folder = folder(args.parts.as_deref(), &args.manifest);
    let mut document = MergedDocument {
        shards: manifest.shards,
        runs: manifest.runs,
        missing: Vec::new(),
        table: args.out.clone(),
        pictures: Vec::new(),
        lost: Vec::new(),
        report: None,
    };
    let (swept, lost) =
        merge_parts(&manifest, &args.manifest, &plan, &folder).inspect_err(|e| {
            if let (SweepError::Incomplete(incomplete), true) = (e, args.output.json) {
                document.missing = incomplete.faults.iter().map(|(index, _)| *index).collect();
                document.table = None;
                args.output.print_with(&document, || {});
            }
        })?;
    if let Some(table) = &table {
        table.write(&swept, &plan.request.axes, &settings.with_lost(&lost))?;
        document.pictures = draw(&swept, table.path())?;
    }
    document.report = Some(Report::of(&swept, manifest.ab.is_some()));
    document.lost = lost;
    document.lost.iter().for_each(|(seed, lost)| errln!("seed {seed}: {lost}"));
    args.output.print_with(&document, || {
        document.report.iter().for_each(|report| outln!("{report}"));
        document.table.iter().chain(&document.pictures).for_each(|p| outln!("{}", p.display()));
    });
    errln!("{} runs of {} shards", manifest.runs, manifest.shards);
    Ok(if document.lost.is_empty() { Exit::Done } else { Exit::Lost })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shard_takes_a_minute_and_has_a_run() {
        assert_eq!(shards(1_000_000, 1.2e-3), 20);
        assert_eq!(shards(500, 1e-3), 1);
        assert_eq!(shards(20, 300.0), 20);
        assert_eq!(shards(1, 0.0), 1);
    }
}
