//! What `bench` takes.

mod page;
mod scan;
mod step;

pub use page::BenchPageArgs;
pub use scan::{BenchScanArgs, DensityWord, PatternWord};
pub use step::BenchStepArgs;

use clap::{Args, Subcommand};

/// `bench`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Every bench measures beside something else in the same run and prints ratios,
the machine, how noisy it was, and a hash of the results. Only release builds on
a machine that is left alone are to be believed: otherwise the results are
printed and the exit code is 1, unless --accept-noise is given.")]
pub struct BenchArgs {
    /// What to measure
    #[command(subcommand)]
    pub what: BenchVerb,
}

/// What to measure.
#[derive(Subcommand, Clone, Debug)]
pub enum BenchVerb {
    /// Nothing but the machine: can what is measured on it be believed?
    Noise(BenchNoiseArgs),
    /// A beam of a scan, beside a ray for each beam
    Scan(BenchScanArgs),
    /// The parts of a tick before it is sent
    Step(BenchStepArgs),
    /// All benches as a page in Markdown, with what the goals came to
    Page(BenchPageArgs),
}

/// What all benches share.
#[derive(Args, Clone, Copy, Debug)]
pub struct BenchCommonArgs {
    /// Take the results of a machine that was too noisy: exit code 0
    #[arg(long)]
    pub accept_noise: bool,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
    /// Show no progress
    #[arg(long, short)]
    pub quiet: bool,
}

/// `bench noise`.
#[derive(Args, Clone, Debug)]
pub struct BenchNoiseArgs {
    /// For how long, s
    #[arg(long, default_value_t = 2.0, value_name = "SECONDS")]
    pub seconds: f64,
    /// What all share.
    #[command(flatten)]
    pub common: BenchCommonArgs,
}
