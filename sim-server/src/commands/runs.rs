//! `runs`: list or remove the folders of runs.

use std::path::{Component, Path, PathBuf};

use anyhow::Result;
use clap::{Args, Subcommand};
use rusty_contract::{Exit, FieldError, TextTable, outln};
use rusty_logs::folder::{FoundRun, OldRun, date_and_time, runs_in};
use serde_json::json;

use super::arguments::Output;

const AFTER_HELP: &str = "\
The folder of a run has a file run.json with name, scenario, seed, start and end of
the run, and the names of the files that it may write. Folders of earlier versions,
which have a run.log only, are listed as well.

Examples:
  sim-server runs                        list the runs in ./runs
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
    /// Remove the folders of runs that have ended
    Remove(RemoveArgs),
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

/// Every folder is looked at before the first one is removed.
fn remove(args: &RemoveArgs) -> Result<Exit> {
    let open = |name: &String| open(&args.dir, name);
    let all: Vec<OldRun> = args.names.iter().map(open).collect::<Result<_, _>>()?;
    all.into_iter().try_for_each(OldRun::remove)?;
    args.output.print_with(&json!({ "removed": args.names }), || {
        args.names.iter().for_each(|name| outln!("removed {}", args.dir.join(name).display()));
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
