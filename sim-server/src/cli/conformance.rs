//! The arguments of `conformance`.

use clap::Args;
use rusty_contract::{Role, RunName};
use rusty_link::WaitPolicy;

/// `conformance`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "The client is started as a launcher would start it: --run, --name, \
    --wait and, for\nscorers and loggers, --key-stdin are appended to its arguments.\n\
    Exit codes: 0 every check passed, 1 one failed, 2 wrong usage, 3 stopped (Ctrl-C).")]
pub struct ConformanceArgs {
    /// Role of the client [possible values: estimator, driver, scorer,
    /// logger, observer]
    #[arg(long, default_value_t = Role::Estimator, value_parser = rusty_conformance::role)]
    pub role: Role,
    /// Name of the client in the roster
    #[arg(long, default_value = "client", value_name = "NAME")]
    pub name: String,
    /// Time limit of each action of the client, s
    #[arg(long, default_value_t = 5.0, value_name = "SECONDS")]
    pub patience: f64,
    /// Waiting method of all processes, balanced, spin or block
    #[arg(long, default_value_t, value_name = "HOW")]
    pub wait: WaitPolicy,
    /// Run this check only; may be repeated
    #[arg(long, value_name = "CHECK")]
    pub only: Vec<String>,
    /// Number of checks that run at the same time
    #[arg(long, default_value_t = 2, value_name = "N")]
    pub jobs: usize,
    /// List the checks with actions, expected results and rules
    #[arg(long)]
    pub list: bool,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
    /// Serve this run until killed; read key and folder from stdin
    #[arg(long, hide = true, value_name = "RUN")]
    pub dies_as: Option<RunName>,
    /// Client and its arguments, after `--`
    #[arg(last = true, required_unless_present_any = ["list", "dies_as"], value_name = "CLIENT")]
    pub client: Vec<String>,
}
