//! The arguments of `control`.

use clap::{Args, Subcommand};
use rusty_contract::RunName;

/// `control`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
No control request changes a bit of the run. `step` replies when its ticks are
complete.")]
pub struct ControlArgs {
    /// Name of the run, as in the first line of the server
    pub run: RunName,
    /// Request to send
    #[command(subcommand)]
    pub wish: ControlVerb,
    /// Time limit of the reply, s
    #[arg(long, default_value_t = 60.0, value_name = "SECONDS", global = true)]
    pub timeout: f64,
    /// Print one JSON document on stdout
    #[arg(long, global = true)]
    pub json: bool,
}

/// The control requests.
#[derive(Subcommand, Clone, Copy, Debug)]
pub enum ControlVerb {
    /// Print the state of the run
    Status,
    /// Pause after the current tick
    Pause,
    /// Advance by TICKS ticks, then pause
    Step {
        /// Number of ticks
        #[arg(default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
        ticks: u64,
    },
    /// Resume at the previous pace
    Resume,
    /// Stop the run after the current tick, like Ctrl-C
    Stop,
}
