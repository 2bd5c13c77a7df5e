//! What `bench` takes.

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
    /// A tick of the protocol beside the raw transport and the machine's floor
    Latency(LatencyArgs),
    /// What waiting costs: a paused run, and one at the pace of real time
    Idle(IdleArgs),
    /// From starting a launch to its first frame, and what memory it takes
    Start(StartArgs),
    /// Writing a log, beside a plain file in the same folder
    Log(BenchLogArgs),
    /// Nothing but the machine: can what is measured on it be believed?
    Noise(BenchNoiseArgs),
    /// A beam of a scan, beside a ray for each beam
    Scan(BenchScanArgs),
    /// The parts of a tick before it is sent
    Step(BenchStepArgs),
    /// Sweeps without clients, on one core and on all
    Sweep(BenchSweepArgs),
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

/// `bench log`.
#[derive(Args, Clone, Debug)]
pub struct BenchLogArgs {
    /// Where to write; nothing stays there
    #[arg(default_value = ".", value_name = "FOLDER")]
    pub folder: PathBuf,
    /// Numbers of beams of the scan in each tick; 0: no scans
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "0,180,1080")]
    pub beams: Vec<usize>,
    /// Ticks of a log
    #[arg(long, value_name = "N", default_value_t = 50_000)]
    pub ticks: u64,
    /// How often each measurement is repeated
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub repeat: usize,
    /// Let the clock run until the disk says that it has everything
    #[arg(long)]
    pub sync: bool,
    /// What all share.
    #[command(flatten)]
    pub common: BenchCommonArgs,
}

/// `bench latency`.
#[derive(Args, Clone, Debug)]
pub struct LatencyArgs {
    /// Numbers of clients, each a process of its own
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "1,2,3,8")]
    pub clients: Vec<usize>,
    /// Numbers of beams
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "180,1080")]
    pub beams: Vec<u32>,
    /// A scan in every so-manyth tick; 0: no scans
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "0,1")]
    pub scan_every: Vec<u64>,
    /// Also measure server, estimator, scorer and logger together
    #[arg(long)]
    pub mix: bool,
    /// Also measure with this program in the place of one dead reckoning, in
    /// turns with it: "python3 clients/python/examples/dead_reckoning.py"
    #[arg(long, value_name = "COMMAND", default_value = "", hide_default_value = true)]
    pub beside: String,
    /// Ticks of a repetition, after a warm-up of a tenth as many
    #[arg(long, value_name = "N", default_value_t = 20_000)]
    pub ticks: usize,
    /// How often each measurement is repeated, in turns with the others
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub repeat: usize,
    /// How everyone waits: balanced, spin (a core each) or block
    #[arg(long, default_value_t, value_name = "HOW")]
    pub wait: WaitPolicy,
    /// Cores to keep everyone on: the server's, then the clients' in turn
    /// [default: where the kernel likes]
    #[arg(long, value_name = "CORE,…", value_delimiter = ',')]
    pub pin: Vec<usize>,
    /// What all share.
    #[command(flatten)]
    pub common: BenchCommonArgs,
}

/// `bench idle`.
#[derive(Args, Clone, Debug)]
pub struct IdleArgs {
    /// For how long each run is watched, s
    #[arg(long, default_value_t = 5.0, value_name = "SECONDS")]
    pub seconds: f64,
    /// How everyone waits: balanced, spin (a core each) or block
    #[arg(long, default_value_t, value_name = "HOW")]
    pub wait: WaitPolicy,
    /// What all share.
    #[command(flatten)]
    pub common: BenchCommonArgs,
}

/// `bench start`.
#[derive(Args, Clone, Debug)]
pub struct StartArgs {
    /// Launches, after one that does not count
    #[arg(long, value_name = "N", default_value_t = 20)]
    pub repeat: usize,
    /// What all share.
    #[command(flatten)]
    pub common: BenchCommonArgs,
}

/// `bench-peer`.
#[derive(Args, Clone, Debug)]
pub struct BenchPeerArgs {
    /// What it takes part in: raw or floor
    pub what: String,
    /// Which of the clients it is, from 0
    pub client: usize,
    /// The run to take part in
    #[arg(long, value_name = "NAME")]
    pub run: RunName,
    /// Its name
    #[arg(long, value_name = "NAME")]
    pub name: String,
    /// How to wait
    #[arg(long, value_name = "HOW")]
    pub wait: WaitPolicy,
    /// Process of the server that started it
    #[arg(long, value_name = "PID")]
    pub launcher: u32,
    /// Taken as by every participant; there is no protocol to sign for
    #[arg(long)]
    pub key_stdin: bool,
}
