//! The arguments of `bench sweep`.

use std::num::NonZeroUsize;

use clap::Args;

use super::BenchCommonArgs;

/// `bench sweep`.
#[derive(Args, Clone, Debug)]
pub struct BenchSweepArgs {
    /// Duration of the measurement, s
    #[arg(long, default_value_t = 6.0, value_name = "SECONDS")]
    pub seconds: f64,
    /// Workers to compare with one [default: one per processor]
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    /// Common options.
    #[command(flatten)]
    pub common: BenchCommonArgs,
}
