//! What `compare` takes.

use std::path::PathBuf;

use clap::Args;

use rusty_study::versus::Metric;

const AFTER_HELP: &str = "\
A row of a sweep is a run of an estimator, and runs of one seed meet the same
noise. So the two are compared seed by seed: mean difference with Student's t
interval, how many seeds each wins (sign test, exact, ties left out), and how many
times as many runs it would have taken without the pairing. Where fields were
swept, each setting is compared by itself: runs of one seed in two settings are not
independent of each other. Less is better in every metric.

Of two tables, the scenario's world, robot and settings must be the same, and the
true way of each pair, to the bit. Otherwise they did not drive the same runs.

Examples:
  sim-server sweep apartment --seeds 0..100 --clients --out t.csv
  sim-server compare t.csv --a dead-reckoning --b my-filter
  sim-server compare before.csv after.csv --a my-filter --metric ate --metric nees";

/// `compare`.
#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_HELP)]
pub struct CompareArgs {
    /// A table that `sweep --out` wrote
    pub table: PathBuf,
    /// Another one, for B
    pub other: Option<PathBuf>,
    /// One estimator [default: the table's, where that leaves no choice]
    #[arg(long, value_name = "NAME")]
    pub a: Option<String>,
    /// The other one; of a second table also the same
    #[arg(long, value_name = "NAME")]
    pub b: Option<String>,
    /// What to compare, again for more [default: those with figures among ate,
    /// final, heading, p95, rpe-metre, nees]
    #[arg(long = "metric", value_name = "METRIC", value_enum, hide_possible_values = false)]
    pub metrics: Vec<Metric>,
    /// Probability of the intervals
    #[arg(long, default_value_t = 0.95, value_name = "P")]
    pub level: f64,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}
