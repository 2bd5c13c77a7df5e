//! What `bench sweep` takes.

use std::num::NonZeroUsize;

use clap::Args;

use super::BenchCommonArgs;

/// `bench sweep`.
#[derive(Args, Clone, Debug)]
pub struct BenchSweepArgs {
    /// For how long, s
    #[arg(long, default_value_t = 6.0, value_name = "SECONDS")]
    pub seconds: f64,
    /// Workers beside the one [default: one per processor]
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    /// What all share.
    #[command(flatten)]
    pub common: BenchCommonArgs,
}
