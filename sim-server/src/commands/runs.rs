//! `runs`: list, compare or remove the folders of runs.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use anyhow::Result;
use clap::{Args, Subcommand};
use rusty_contract::score::{Score, degrees, metres};
use rusty_contract::{Exit, FieldError, ScoreReport, TextTable, errln, outln};
use rusty_logs::folder::{FoundRun, Marker, OldRun, date_and_time, runs_in};
use serde::Serialize;
use serde_json::json;

use super::arguments::Output;

const AFTER_HELP: &str = "\
The folder of a run has a file run.json with name, scenario, seed, start and end of
the run, and the names of the files that it may write. Folders of earlier versions,
which have a run.log only, are listed as well.

Examples:
  sim-server runs                        list the runs in ./runs
  sim-server runs compare lab night-2    compare the scores of two runs
  sim-server runs remove lab night-2     remove two runs";

#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_HELP, args_conflicts_with_subcommands = true)]
pub struct RunsArgs {
    /// Action [default: list the runs]
    #[command(subcommand)]
    pub what: Option<RunsVerb>,
    /// Folder with the folders of runs
    #[arg(default_value = "runs", value_name = "DIR")]
    pub dir: PathBuf,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Subcommand, Clone, Debug)]
pub enum RunsVerb {
    /// Compare the scores of runs
    Compare(CompareArgs),
    /// Remove the folders of runs that have ended
    Remove(RemoveArgs),
}

#[derive(Args, Clone, Debug)]
pub struct CompareArgs {
    /// Names of the folders, as `runs` lists them
    #[arg(required = true, num_args = 2.., value_name = "NAME")]
    pub names: Vec<String>,
    /// Folder with the folders of runs
    #[arg(long = "in", default_value = "runs", value_name = "DIR")]
    pub dir: PathBuf,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Args, Clone, Debug)]
pub struct RemoveArgs {
    /// Names of the folders, as `runs` lists them
    #[arg(required = true, value_name = "NAME")]
    pub names: Vec<String>,
    /// Folder with the folders of runs
    #[arg(long = "in", default_value = "runs", value_name = "DIR")]
    pub dir: PathBuf,
    #[command(flatten)]
    pub output: Output,
}

pub fn run(args: &RunsArgs) -> Result<Exit> {
    match &args.what {
        Some(RunsVerb::Compare(args)) => compare(args),
        Some(RunsVerb::Remove(args)) => remove(args),
        None => list(args),
    }
}

fn list(args: &RunsArgs) -> Result<Exit> {
    let found = runs_in(&args.dir)?;
    args.output.print_with(&found, || print(&args.dir, &found));
    Ok(Exit::Done)
}

fn print(dir: &Path, found: &[FoundRun]) {
    if found.is_empty() {
        return outln!("no runs in {}", dir.display());
    }
    let mut table =
        TextTable::new("name  scenario  >seed  >ticks  >digest  >started (UTC)  >size  state");
    for run in found {
        let end = run.marker.end.as_ref();
        table.row(&[
            &run.name,
            &run.marker.scenario,
            &run.marker.seed.map_or_else(|| "-".to_owned(), |seed| seed.to_string()),
            &end.map_or_else(|| "-".to_owned(), |end| end.ticks.to_string()),
            &end.map_or("-", |end| &end.digest),
            &date_and_time(run.marker.started_unix_s),
            &format!("{:.1} MB", run.bytes as f64 / 1e6),
            &run.state(),
        ]);
    }
    outln!("{table}");
}

/// A run of a comparison.
#[derive(Serialize)]
struct ComparedRun {
    name: String,
    #[serde(flatten)]
    marker: Marker,
    /// One per estimator; none without a scorer.
    scores: Vec<Score>,
}

impl ComparedRun {
    fn read(dir: &Path, name: &str) -> Result<Self> {
        let path = dir.join(name);
        let marker = Marker::of(&path).ok_or_else(|| {
            let problem = format!("is not the folder of a run in {}", dir.display());
            FieldError::new("NAME", name, problem, "give a name that `sim-server runs` lists")
        })?;
        // The file may be of another run.
        let digest = marker.end.as_ref().map(|end| &*end.digest);
        let scored = ScoreReport::read(&path.join("score.json"), digest);
        let scores = scored.map(|report| report.scores).unwrap_or_else(|why| {
            errln!("{name}: no scores: {why}; `score --log` makes them from its log");
            Vec::new()
        });
        Ok(Self { name: name.to_owned(), marker, scores })
    }
}

fn compare(args: &CompareArgs) -> Result<Exit> {
    let read = |name: &String| ComparedRun::read(&args.dir, name);
    let runs: Vec<ComparedRun> = args.names.iter().map(read).collect::<Result<_>>()?;
    args.output.print_with(&runs, || print_comparison(&runs));
    Ok(Exit::Done)
}

fn print_comparison(runs: &[ComparedRun]) {
    let mut table = TextTable::new("run  scenario  >seed  >ticks  >digest");
    for ComparedRun { name, marker, .. } in runs {
        let seed = marker.seed.map_or_else(|| "-".to_owned(), |seed| seed.to_string());
        let ticks = marker.end.as_ref().map_or_else(|| "-".to_owned(), |e| e.ticks.to_string());
        let digest = marker.end.as_ref().map_or("-", |end| &end.digest);
        table.row(&[name, &marker.scenario, &seed, &ticks, &digest]);
    }
    outln!("{table}");
    let mut estimators: Vec<&str> = Vec::new();
    for score in runs.iter().flat_map(|run| &run.scores) {
        if !estimators.contains(&score.name.as_str()) {
            estimators.push(&score.name);
        }
    }
    let mut table =
        TextTable::new("estimator  run  alignment  >final  >heading  >mean  >p95  >ATE rmse");
    let cell = |value: Option<f64>, number: fn(f64) -> String, unit: &str| {
        value.map_or_else(|| "unscored".to_owned(), |value| format!("{} {unit}", number(value)))
    };
    for estimator in &estimators {
        for run in runs {
            for score in run.scores.iter().filter(|score| score.name == *estimator) {
                let figures = score.figures(score.alignment);
                table.row(&[
                    estimator,
                    &run.name,
                    &score.alignment.word(),
                    &cell(figures.final_position_error_m, metres, "m"),
                    &cell(figures.final_heading_error_rad.map(f64::to_degrees), degrees, "°"),
                    &cell(figures.mean_position_error_m, metres, "m"),
                    &cell(figures.p95_position_error_m, metres, "m"),
                    &cell(figures.ate_rmse_m, metres, "m"),
                ]);
            }
        }
    }
    if !estimators.is_empty() {
        outln!("\n{table}");
    }
}

/// Every folder is looked at before the first one is removed.
fn remove(args: &RemoveArgs) -> Result<Exit> {
    let open = |name: &String| open(&args.dir, name);
    let names: BTreeSet<&String> = args.names.iter().collect();
    let all: Vec<OldRun> = names.iter().copied().map(open).collect::<Result<_, _>>()?;
    all.into_iter().try_for_each(OldRun::remove)?;
    args.output.print_with(&json!({ "removed": names }), || {
        names.iter().for_each(|name| outln!("removed {}", args.dir.join(name).display()));
    });
    Ok(Exit::Done)
}

/// The folder of a run that may be removed: in `dir`, and not a link to another
/// place.
fn open(dir: &Path, name: &str) -> Result<OldRun> {
    let mut parts = Path::new(name).components();
    let is_name = matches!((parts.next(), parts.next()), (Some(Component::Normal(_)), None));
    let path = dir.join(name);
    let refused = |problem: &str| {
        let remedy = "give a name that `sim-server runs` lists";
        anyhow::Error::from(FieldError::new("NAME", name, problem, remedy))
    };
    if !is_name {
        return Err(refused("is not the name of a folder"));
    }
    match path.symlink_metadata() {
        Ok(found) if found.is_dir() => Ok(OldRun::open(&path)?),
        Ok(found) if found.is_symlink() => Err(refused("is a link, and links are not followed")),
        Ok(_) => Err(refused("is a file, not the folder of a run")),
        Err(_) => Err(refused(&format!("is not in {}", dir.display()))),
    }
}
