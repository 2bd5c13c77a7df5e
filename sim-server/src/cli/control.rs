//! What `control` takes.

use clap::{Args, Subcommand};
use rusty_contract::RunName;

/// `control`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "None of this changes a bit of the run.")]
pub struct ControlArgs {
    /// Name of the run, as on the server's first line
    pub run: RunName,
    /// What to do
    #[command(subcommand)]
    pub wish: ControlVerb,
    /// How long to wait for the reply, s: `step` replies when its ticks are done
    #[arg(long, default_value_t = 60.0, value_name = "SECONDS", global = true)]
    pub timeout: f64,
    /// Print one JSON document on stdout
    #[arg(long, global = true)]
    pub json: bool,
}

/// What to say to a run.
#[derive(Subcommand, Clone, Copy, Debug)]
pub enum ControlVerb {
    /// Say where it stands
    Status,
    /// No tick after the one that is being worked on
    Pause,
    /// So many ticks more, then pause; returns when they are complete
    Step {
        /// How many
        #[arg(default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
        ticks: u64,
    },
    /// On, at the pace it had
    Resume,
    /// End it after this tick, as by Ctrl-C
    Stop,
}
