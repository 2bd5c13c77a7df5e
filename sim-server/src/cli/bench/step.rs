//! The arguments of `bench step`.

use clap::Args;

use super::BenchCommonArgs;

/// `bench step`.
#[derive(Args, Clone, Debug)]
pub struct BenchStepArgs {
    /// Duration of the measurement, s
    #[arg(long, default_value_t = 3.0, value_name = "SECONDS")]
    pub seconds: f64,
    /// Common options.
    #[command(flatten)]
    pub common: BenchCommonArgs,
}
