//! The arguments of `bench`.

use std::path::PathBuf;
mod page;
mod scan;
mod step;
mod sweep;

pub use page::BenchPageArgs;
pub use scan::{BenchScanArgs, DensityWord, PatternWord};
pub use step::BenchStepArgs;
pub use sweep::BenchSweepArgs;

use clap::{Args, Subcommand};
use rusty_contract::RunName;
use rusty_link::WaitPolicy;

/// `bench`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Every benchmark measures its subject and a baseline in turns in the same run. It
prints ratios, the machine, the noise of the machine, and a hash of the results.
Results are valid for release builds on an otherwise idle machine. In all other
cases they are printed and the exit code is 1, unless --accept-noise is given.")]
pub struct BenchArgs {
    /// Benchmark to run
    #[command(subcommand)]
    pub what: BenchVerb,
}

/// The benchmarks.
#[derive(Subcommand, Clone, Debug)]
pub enum BenchVerb {
    /// Measure a tick against the raw transport and a lower bound
    Latency(LatencyArgs),
    /// Measure the CPU time of a paused and of a real-time run
    Idle(IdleArgs),
    /// Measure time to the first frame and memory of a launch
    Start(StartArgs),
    /// Measure writing a log against writing a plain file
    Log(BenchLogArgs),
    /// Measure the noise of this machine
    Noise(BenchNoiseArgs),
    /// Measure a scan against one ray cast per beam
    Scan(BenchScanArgs),
    /// Measure the parts of a tick before it is sent
    Step(BenchStepArgs),
    /// Measure sweeps without clients on one core and on all
    Sweep(BenchSweepArgs),
    /// Write all benchmarks and their goals as a Markdown page
    Page(BenchPageArgs),
}

/// Options of every benchmark.
#[derive(Args, Clone, Copy, Debug)]
pub struct BenchCommonArgs {
    /// Exit with 0 although the machine was too noisy
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
    /// Duration of the measurement, s
    #[arg(long, default_value_t = 2.0, value_name = "SECONDS")]
    pub seconds: f64,
    /// Common options.
    #[command(flatten)]
    pub common: BenchCommonArgs,
}

/// `bench log`.
#[derive(Args, Clone, Debug)]
pub struct BenchLogArgs {
    /// Folder to write to; it is left as it was
    #[arg(default_value = ".", value_name = "FOLDER")]
    pub folder: PathBuf,
    /// Numbers of beams of the scan in each tick, 0 for no scans
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "0,180,1080")]
    pub beams: Vec<usize>,
    /// Number of ticks of a log
    #[arg(long, value_name = "N", default_value_t = 50_000)]
    pub ticks: u64,
    /// Repetitions of each measurement
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub repeat: usize,
    /// Include the time until the disk has stored everything
    #[arg(long)]
    pub sync: bool,
    /// Common options.
    #[command(flatten)]
    pub common: BenchCommonArgs,
}

/// `bench latency`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example: sim-server bench latency \
    --beside \"python3 clients/python/examples/dead_reckoning.py\"")]
pub struct LatencyArgs {
    /// Numbers of clients, each a separate process
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "1,2,3,8")]
    pub clients: Vec<usize>,
    /// Numbers of beams
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "180,1080")]
    pub beams: Vec<u32>,
    /// Scan every N ticks, 0 for no scans
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "0,1")]
    pub scan_every: Vec<u64>,
    /// Also measure server, estimator, scorer and logger together
    #[arg(long)]
    pub mix: bool,
    /// Also measure this program in place of one dead reckoning
    #[arg(long, value_name = "COMMAND", default_value = "", hide_default_value = true)]
    pub beside: String,
    /// Ticks of a repetition, after a warm-up of a tenth of them
    #[arg(long, value_name = "N", default_value_t = 20_000)]
    pub ticks: usize,
    /// Repetitions of each measurement, in turns with the others
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub repeat: usize,
    /// Waiting method of all processes, balanced, spin or block
    #[arg(long, default_value_t, value_name = "HOW")]
    pub wait: WaitPolicy,
    /// Cores of the server, then of the clients in turn
    /// [default: chosen by the kernel]
    #[arg(long, value_name = "CORE,…", value_delimiter = ',')]
    pub pin: Vec<usize>,
    /// Common options.
    #[command(flatten)]
    pub common: BenchCommonArgs,
}

/// `bench idle`.
#[derive(Args, Clone, Debug)]
pub struct IdleArgs {
    /// Duration of the measurement of each run, s
    #[arg(long, default_value_t = 5.0, value_name = "SECONDS")]
    pub seconds: f64,
    /// Waiting method of all processes, balanced, spin or block
    #[arg(long, default_value_t, value_name = "HOW")]
    pub wait: WaitPolicy,
    /// Common options.
    #[command(flatten)]
    pub common: BenchCommonArgs,
}

/// `bench start`.
#[derive(Args, Clone, Debug)]
pub struct StartArgs {
    /// Number of launches, after one that is not counted
    #[arg(long, value_name = "N", default_value_t = 20)]
    pub repeat: usize,
    /// Common options.
    #[command(flatten)]
    pub common: BenchCommonArgs,
}

/// `bench-peer`.
#[derive(Args, Clone, Debug)]
pub struct BenchPeerArgs {
    /// Benchmark to take part in, raw or floor
    pub what: String,
    /// Index of this client, counted from 0
    pub client: usize,
    /// Run to take part in
    #[arg(long, value_name = "NAME")]
    pub run: RunName,
    /// Name of this client
    #[arg(long, value_name = "NAME")]
    pub name: String,
    /// Waiting method
    #[arg(long, value_name = "HOW")]
    pub wait: WaitPolicy,
    /// Process ID of the server that started this client
    #[arg(long, value_name = "PID")]
    pub launcher: u32,
    /// Accepted for uniformity and not used
    #[arg(long)]
    pub key_stdin: bool,
}
