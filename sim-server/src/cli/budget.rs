//! What `budget` takes.

use clap::Args;

use rusty_study::sweep::Seeds;

const AFTER_HELP: &str = "\
Dead reckoning is wrong because wheel and floor differ, for three reasons that
behave differently. Encoders round to whole counts: it is there and does not
matter. Wheels slip: chance, another error on every seed, which grows. Wheels or
wheelbase are not what they are said to be: the same error on every seed, which
no averaging removes; calibrate it (`sim-server umbmark`). The budget runs the
scenario with each of them alone and with all together, and says how far off dead
reckoning is at the end. Quantization is in every row.

A share is of mean squares, which add up where sources are independent and small.

Scans are not made and clients do not take part. A scenario that a client drives
stands still here; one with a truth-steered patrol is steered in every row.

Examples:
  sim-server budget patrol --set robot.radius_bias_right=0.01    the chapter's table
  sim-server budget figure-eight --seeds 0..100 --set robot.track_bias=0.005";

/// `budget`.
#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_HELP)]
pub struct BudgetArgs {
    /// A scenario file, or one of: apartment, patrol, figure-eight, hallway, driver
    #[arg(default_value = "patrol")]
    pub scenario: String,
    /// Seeds: A..B without B, A..=B with it, or one
    #[arg(long, value_name = "A..B", default_value = "0..500")]
    pub seeds: Seeds,
    /// Number of ticks [default: the scenario's]
    #[arg(long)]
    pub ticks: Option<u64>,
    /// Change a field, e.g. --set robot.radius_bias_right=0.01
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<String>,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
    /// Show no progress
    #[arg(long, short)]
    pub quiet: bool,
}
