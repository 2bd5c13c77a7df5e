//! `sweep`: a scenario with many seeds and settings, a row per run.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rusty_contract::{Exit, FieldError, errln, outln};
use serde::Serialize;
use signal_hook::consts::{SIGINT, SIGTERM};

use super::launch::writer;
use super::{Verbed, print_json};
use crate::cli::SweepArgs;
use crate::error::VerbError;
use rusty_bench::machine::cores;
use rusty_engine::run::Progress;
use rusty_study::sweep::report::{Report, draw};
use rusty_study::sweep::{Axis, Came, Plan, Request, Sweeping, Table};

/// Makes every run and writes the table.
///
/// # Errors
/// [`VerbError`] if the sweep cannot be begun or kept; losses in its runs, and
/// Ctrl-C, are an exit code.
pub fn sweep(args: &SweepArgs) -> Verbed {
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
    let sweeping = Sweeping {
        plan,
        writer: writer(),
        jobs: jobs(args),
        table,
        resume: args.resume,
        force: args.force,
        runs_dir: args.runs.clone(),
    };
    let stop = Arc::<AtomicBool>::default();
    for signal in [SIGINT, SIGTERM] {
        // Twice is now: what is done is in the journal.
        let code = Exit::Lost as i32;
        signal_hook::flag::register_conditional_shutdown(signal, code, Arc::clone(&stop))
            .and_then(|_| signal_hook::flag::register(signal, Arc::clone(&stop)))
            .map_err(VerbError::io(Path::new("signals")))?;
    }
    let progress = Progress::new(ticks, args.quiet || args.json);
    let came = sweeping.carry_out(&stop, progress)?;
    let complete = came.runs == came.planned && !came.was_complete;
    let report = complete.then(|| Report::of(&came.swept, args.ab.is_some()));
    let pictures = match &args.out {
        Some(out) if complete => draw(&came.swept, out)?,
        _ => Vec::new(),
    };
    Ok(say(args, &came, report, &pictures))
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

fn jobs(args: &SweepArgs) -> usize {
    args.jobs.map_or_else(cores, usize::from)
}

/// What a sweep came to, for `--json`.
#[derive(Serialize)]
struct Document<'a> {
    scenario: &'a str,
    seeds: String,
    shard: String,
    /// The swept fields of each cell.
    cells: Vec<&'a [(String, String)]>,
    /// Runs whose rows are there, and runs there were to be.
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
    /// What is done of an interrupted sweep.
    journal: Option<String>,
    pictures: Vec<String>,
    /// Runs in which something was lost: seed and what.
    lost: &'a [(u64, String)],
    /// What the rows say; null if not all are there, or were before.
    report: Option<Report>,
}

fn say(args: &SweepArgs, came: &Came, report: Option<Report>, pictures: &[PathBuf]) -> Exit {
    let interrupted = came.runs < came.planned;
    let shown = |path: &Path| path.display().to_string();
    let per_s = if came.elapsed_s > 0.0 { came.ticks as f64 / came.elapsed_s } else { 0.0 };
    if let (Some(report), false) = (&report, args.json) {
        outln!("{report}");
    }
    if args.json {
        print_json(&Document {
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
        });
    }
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
    } else if !args.json {
        args.out.iter().chain(pictures).for_each(|path| outln!("{}", path.display()));
    }
    if interrupted || !came.lost.is_empty() { Exit::Lost } else { Exit::Done }
}
