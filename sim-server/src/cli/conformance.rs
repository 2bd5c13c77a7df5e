//! What `conformance` takes.

use clap::Args;
use rusty_contract::{Role, RunName};
use rusty_link::WaitPolicy;

/// `conformance`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "The client is started as a launcher would start it: --run, --name, \
    --wait and, for\nscorers and loggers, --key-stdin are appended to its arguments.\n\
    Exit codes: 0 every check passed, 1 one failed, 2 wrong usage, 3 stopped (Ctrl-C).")]
pub struct ConformanceArgs {
    /// What the client takes part as: estimator, driver, scorer, logger or observer
    #[arg(long, default_value_t = Role::Estimator, value_parser = rusty_conformance::role)]
    pub role: Role,
    /// Name it is given in the roster
    #[arg(long, default_value = "client", value_name = "NAME")]
    pub name: String,
    /// The longest wait for anything the client must do, s
    #[arg(long, default_value_t = 5.0, value_name = "SECONDS")]
    pub patience: f64,
    /// How everyone waits: balanced, spin (a core each) or block
    #[arg(long, default_value_t, value_name = "HOW")]
    pub wait: WaitPolicy,
    /// Make this check alone (may be given more than once)
    #[arg(long, value_name = "CHECK")]
    pub only: Vec<String>,
    /// How many checks are made at a time
    #[arg(long, default_value_t = 2, value_name = "N")]
    pub jobs: usize,
    /// List the checks: what each does, what it expects, which rule it is about
    #[arg(long)]
    pub list: bool,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
    /// Serve this run until killed; key and folder come on standard input
    #[arg(long, hide = true, value_name = "RUN")]
    pub dies_as: Option<RunName>,
    /// The client and its arguments, after `--`
    #[arg(last = true, required_unless_present_any = ["list", "dies_as"], value_name = "CLIENT")]
    pub client: Vec<String>,
}
