//! What `bench step` takes.

use clap::Args;

use super::BenchCommonArgs;

/// `bench step`.
#[derive(Args, Clone, Debug)]
pub struct BenchStepArgs {
    /// For how long, s
    #[arg(long, default_value_t = 3.0, value_name = "SECONDS")]
    pub seconds: f64,
    /// What all share.
    #[command(flatten)]
    pub common: BenchCommonArgs,
}
