//! The arguments of `budget`.

use clap::Args;

use rusty_study::sweep::Seeds;

const AFTER_HELP: &str = "\
The error of dead reckoning has three sources:
  quantization   encoders round to whole counts; the error is negligible
  slip           random, different on every seed, grows with the distance
  bias           wheels or wheelbase differ from their nominal values; the same
                 error on every seed, which averaging does not remove; calibrate
                 it with `sim-server umbmark`
The budget runs the scenario with each source alone and with all together, and
prints the final error of dead reckoning. Quantization is in every row.

Shares are of mean squares, which add up if sources are independent and small.

No scans are made and no clients take part. The robot of a scenario with a driver
does not move here; a truth-steered patrol is steered in every row.

Examples:
  sim-server budget patrol --set robot.radius_bias_right=0.01    the chapter's table
  sim-server budget figure-eight --seeds 0..100 --set robot.track_bias=0.005";

/// `budget`.
#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_HELP)]
pub struct BudgetArgs {
    /// apartment, patrol, figure-eight, hallway, driver or a file
    #[arg(default_value = "patrol")]
    pub scenario: String,
    /// Seeds A..B (without B), A..=B (with B) or one seed
    #[arg(long, value_name = "A..B", default_value = "0..500")]
    pub seeds: Seeds,
    /// Number of ticks [default: the scenario's]
    #[arg(long)]
    pub ticks: Option<u64>,
    /// Change a field, e.g. robot.radius_bias_right=0.01
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<String>,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
    /// Show no progress
    #[arg(long, short)]
    pub quiet: bool,
}
