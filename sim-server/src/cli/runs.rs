//! The arguments of `runs`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

const AFTER_HELP: &str = "\
The folder of a run has a file run.json with name, scenario, seed, start and end of
the run, and the names of the files that it may write. Folders of earlier versions,
which have a run.log only, are listed as well.

Examples:
  sim-server runs                        list the runs in ./runs
  sim-server runs remove lab night-2     remove two runs";

/// `runs`.
#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_HELP, args_conflicts_with_subcommands = true)]
pub struct RunsArgs {
    /// Action [default: list the runs]
    #[command(subcommand)]
    pub what: Option<RunsVerb>,
    /// Folder with the folders of runs
    #[arg(default_value = "runs", value_name = "DIR")]
    pub dir: PathBuf,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// The actions on runs.
#[derive(Subcommand, Clone, Debug)]
pub enum RunsVerb {
    /// Remove the folders of runs that have ended
    Remove(RemoveArgs),
}

/// `runs remove`.
#[derive(Args, Clone, Debug)]
pub struct RemoveArgs {
    /// Names of the folders, as `runs` lists them
    #[arg(required = true, value_name = "NAME")]
    pub names: Vec<String>,
    /// Folder with the folders of runs
    #[arg(long = "in", default_value = "runs", value_name = "DIR")]
    pub dir: PathBuf,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}
