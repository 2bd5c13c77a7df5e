//! The arguments of `runs`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

const AFTER_HELP: &str = "\
A run's folder holds run.json: name, scenario, seed, start and end of the run, and
the names of the files that it may write. Folders that hold a run.log alone, from
earlier versions, are listed as well.

Examples:
  sim-server runs                        the runs in ./runs
  sim-server runs remove lab night-2     remove two of them";

/// `runs`.
#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_HELP, args_conflicts_with_subcommands = true)]
pub struct RunsArgs {
    /// What to do with them; without it they are listed
    #[command(subcommand)]
    pub what: Option<RunsVerb>,
    /// Folder that holds the folders of runs
    #[arg(default_value = "runs", value_name = "DIR")]
    pub dir: PathBuf,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// What to do with runs.
#[derive(Subcommand, Clone, Debug)]
pub enum RunsVerb {
    /// Remove the folders of runs that are over
    Remove(RemoveArgs),
}

/// `runs remove`.
#[derive(Args, Clone, Debug)]
pub struct RemoveArgs {
    /// Names of the folders, as `runs` lists them
    #[arg(required = true, value_name = "NAME")]
    pub names: Vec<String>,
    /// Folder that holds the folders of runs
    #[arg(long = "in", default_value = "runs", value_name = "DIR")]
    pub dir: PathBuf,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}
