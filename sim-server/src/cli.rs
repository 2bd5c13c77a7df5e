//! The command line: arguments in, one verb called, an exit code out.

mod bench;
mod budget;
mod compare;
mod conformance;
mod control;
mod export;
mod runs;
mod seed;
mod sweep;
mod umbmark;

pub use bench::{
    BenchArgs, BenchCommonArgs, BenchLogArgs, BenchNoiseArgs, BenchPageArgs, BenchPeerArgs,
    BenchScanArgs, BenchStepArgs, BenchSweepArgs, BenchVerb, DensityWord, IdleArgs, LatencyArgs,
    PatternWord, StartArgs,
};
pub use budget::BudgetArgs;
pub use compare::CompareArgs;
pub use conformance::ConformanceArgs;
pub use control::{ControlArgs, ControlVerb};
pub use export::{ExportArgs, ExportVerb};
pub use runs::{RemoveArgs, RunsArgs, RunsVerb};
pub use sweep::SweepArgs;
pub use umbmark::UmbmarkArgs;

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use rusty_contract::{RunName, Sandbox};
use rusty_link::WaitPolicy;

use rusty_engine::run::Pace;

/// A lockstep robot simulator: one world, published tick by tick into shared
/// memory, to processes that must answer before time goes on.
#[derive(Parser)]
#[command(name = "sim-server", version, after_help = AFTER_HELP, propagate_version = true)]
pub struct Cli {
    #[command(subcommand)]
    pub verb: Verb,
}

const AFTER_HELP: &str = "\
Examples:
  sim-server launch                              the Apartment, dead reckoning, scores, picture
  sim-server launch --seed 7 --ticks 3000        another seed, a minute
  sim-server launch --add mine=./target/release/mine   your own filter beside it
  sim-server verify runs/NAME/run.log            the same bits again?
  sim-server replay runs/NAME/run.log            the same frames to the same clients

Results go to stdout, talk to stderr; --json prints one JSON document.
Exit codes: 0 done, 1 failed, 2 wrong usage, 3 finished but something was lost
(a participant, data, or the end of the run), 4 not bit-exact.";

#[derive(Subcommand)]
pub enum Verb {
    /// Run a scenario: server and participants as processes; table, digest, picture
    Launch(LaunchArgs),
    /// Serve a scenario; participants join by name and are started by hand
    Serve(ServeArgs),
    /// Play a log to the same participants again, in lockstep
    Replay(ReplayArgs),
    /// Simulate a log's run again and compare every bit
    Verify(VerifyArgs),
    /// Run a log's scenario again, with something changed from a tick on
    Fork(ForkArgs),
    /// Run a scenario with many seeds and settings: a table, a row per run
    Sweep(SweepArgs),
    /// Say which of two estimators is better, from the tables of sweeps
    Compare(CompareArgs),
    /// Say how much of the odometry's error comes from where
    Budget(BudgetArgs),
    /// Drive a square both ways round: what is wrong with wheels and wheelbase?
    Umbmark(UmbmarkArgs),
    /// Compare two logs: first tick, field and bits that differ
    Diff(DiffArgs),
    /// Say what is in a log
    Info(InfoArgs),
    /// Write a log for other programs: trajectories for evo, or a table
    Export(ExportArgs),
    /// Split a log into a blind one to hand out and the key to its truth
    Seal(SealArgs),
    /// List the built-in worlds, draw one, or scan it without noise
    Worlds(WorldsArgs),
    /// Print the layout of the structs in shared memory
    Layout(JsonArgs),
    /// Make a run log from the recording of a real robot
    #[command(subcommand)]
    Import(ImportVerb),
    /// Pause a running server, let it go on step by step, resume or stop it
    Control(ControlArgs),
    /// Check this machine: the same bits as everywhere? shared memory?
    Doctor(JsonArgs),
    /// Test a client program, in whatever language, against the protocol
    Conformance(ConformanceArgs),
    /// Measure speed, beside what it is to be compared with
    Bench(BenchArgs),
    /// List the folders of runs, or remove some
    Runs(RunsArgs),
    /// Remove what dead runs left in shared memory; living ones stay
    Clean(JsonArgs),
    /// Take part in a bench without a protocol (the bench does this)
    #[command(hide = true)]
    BenchPeer(BenchPeerArgs),
    /// Confine this process, then become a participant (the server does this)
    #[command(hide = true)]
    Confined(ConfinedArgs),
}

/// What all runs share.
#[derive(Args, Clone, Debug)]
pub struct RunArgs {
    /// Name of the run [default: the scenario's and a random ending]
    #[arg(long, value_name = "NAME")]
    pub run: Option<RunName>,
    /// Folder for log, scores and picture [default: runs/NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the whole folder of a run that is over
    #[arg(long)]
    pub force: bool,
    /// Simulated time: max, real, or a factor such as 2.5
    #[arg(long, default_value = "max", value_name = "P")]
    pub pace: Pace,
    /// Begin paused: `sim-server control RUN step` or `resume` lets it go on
    #[arg(long)]
    pub paused: bool,
    /// How everyone waits: balanced, spin (a core each) or block
    #[arg(long, default_value_t, value_name = "HOW")]
    pub wait: WaitPolicy,
    /// How long an answer may take, s [default: the scenario's]
    #[arg(long, value_name = "SECONDS")]
    pub answer_timeout: Option<f64>,
    /// How long the participants may take to join, s [default: the scenario's]
    #[arg(long, value_name = "SECONDS")]
    pub join_timeout: Option<f64>,
    /// Add an estimator: NAME, or NAME=COMMAND to have it started; `{out}` in the
    /// command stands for the run's folder
    #[arg(long, value_name = "NAME[=COMMAND]")]
    pub add: Vec<String>,
    /// Confine all that are started and hold no key: none, if-possible or
    /// required [default: the scenario's]
    #[arg(long, value_name = "HOW")]
    pub sandbox: Option<Sandbox>,
    /// Leave a participant out
    #[arg(long, value_name = "NAME")]
    pub without: Vec<String>,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
    /// Show no progress
    #[arg(long, short)]
    pub quiet: bool,
}

/// Which scenario, and what to change in it.
#[derive(Args, Clone, Debug)]
pub struct ScenarioArgs {
    /// A scenario file, or one of: apartment, patrol, figure-eight, hallway, driver
    #[arg(default_value = "apartment")]
    pub scenario: String,
    /// Seed of all noise: a number, or random [default: the scenario's]
    #[arg(long, value_parser = seed::seed_or_random, allow_hyphen_values = true)]
    pub seed: Option<u64>,
    /// Number of ticks [default: the scenario's]
    #[arg(long)]
    pub ticks: Option<u64>,
    /// Change a field, e.g. --set robot.slip_std=0.05
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<String>,
}

/// `launch`.
#[derive(Args, Clone, Debug)]
pub struct LaunchArgs {
    /// The scenario.
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// The run.
    #[command(flatten)]
    pub run: RunArgs,
}

/// `serve`.
#[derive(Args, Clone, Debug)]
pub struct ServeArgs {
    /// The scenario.
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// The run.
    #[command(flatten)]
    pub run: RunArgs,
}

/// `replay`.
#[derive(Args, Clone, Debug)]
pub struct ReplayArgs {
    /// The log to play
    pub log: PathBuf,
    /// Start nobody; wait for participants started by hand
    #[arg(long)]
    pub attach: bool,
    /// The run.
    #[command(flatten)]
    pub run: RunArgs,
}

/// `verify`.
#[derive(Args, Clone, Debug)]
pub struct VerifyArgs {
    /// The log
    pub log: PathBuf,
    /// Run its estimators and driver again on the frames, too, and compare
    /// every answer; the roster's programs are started as `replay` starts them
    #[arg(long)]
    pub clients: bool,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// `diff`.
#[derive(Args, Clone, Debug)]
pub struct DiffArgs {
    /// One log
    pub a: PathBuf,
    /// The other
    pub b: PathBuf,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// `info`.
#[derive(Args, Clone, Debug)]
pub struct InfoArgs {
    /// The log
    pub log: PathBuf,
    /// One tick instead, from 0
    #[arg(long, value_name = "N")]
    pub tick: Option<u64>,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// `fork`.
#[derive(Args, Clone, Debug)]
pub struct ForkArgs {
    /// The log of a simulated run
    pub log: PathBuf,
    /// The first tick that is another; those before it are the log's to the bit
    #[arg(long, value_name = "TICK")]
    pub at: u64,
    /// Change a field from that tick on, e.g. --set robot.slip_std=0.05
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<String>,
    /// Seed from that tick on: a number, or random [default: the log's]
    #[arg(long, value_parser = seed::seed_or_random, allow_hyphen_values = true)]
    pub seed: Option<u64>,
    /// Number of ticks in all [default: the log's]
    #[arg(long)]
    pub ticks: Option<u64>,
    /// The run.
    #[command(flatten)]
    pub run: RunArgs,
}

/// `seal`.
#[derive(Args, Clone, Debug)]
pub struct SealArgs {
    /// The log, of a simulation or a recording
    pub log: PathBuf,
    /// The blind log to write: no truth, no seed, no true parameters
    #[arg(short, long, value_name = "BLIND")]
    pub output: PathBuf,
    /// The key to write (mode 0600): what the blind log lacks
    #[arg(long, value_name = "FILE")]
    pub key_file: PathBuf,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// `worlds`.
#[derive(Args, Clone, Debug)]
pub struct WorldsArgs {
    /// A built-in world, or a world file
    pub name: Option<String>,
    /// Scan it without noise from this sensor pose, in m, m, rad
    #[arg(long, value_name = "X,Y,THETA", allow_hyphen_values = true, requires = "name")]
    pub scan: Option<String>,
    /// Beams of the scan, over the full circle
    #[arg(long, default_value_t = 180)]
    pub beams: u32,
    /// Longest range of the scan, m
    #[arg(long, default_value_t = 8.0)]
    pub range_max: f64,
    /// Draw it into this SVG file
    #[arg(long, value_name = "FILE", requires = "name")]
    pub svg: Option<PathBuf>,
    /// Replace a drawing that is there
    #[arg(long, requires = "svg")]
    pub force: bool,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// A verb with nothing to say but how to print.
#[derive(Args, Clone, Debug)]
pub struct JsonArgs {
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// `confined`.
#[derive(Args, Clone, Debug)]
pub struct ConfinedArgs {
    /// The run whose shared memory it may use
    #[arg(long, value_name = "NAME")]
    pub cell: RunName,
    /// if-possible, or required: fail if the kernel takes less than all rules
    #[arg(long, value_name = "HOW")]
    pub sandbox: Sandbox,
    /// A file or folder that it may read
    #[arg(long, value_name = "PATH")]
    pub file: Vec<PathBuf>,
    /// A folder in which it may write
    #[arg(long, value_name = "PATH")]
    pub own_folder: Option<PathBuf>,
    /// The program to become
    pub program: OsString,
    /// Its arguments
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pub args: Vec<OsString>,
}

#[derive(Subcommand)]
pub enum ImportVerb {
    /// A CARMEN log (ODOM and FLASER lines), plain or gzip
    Carmen(CarmenArgs),
}

/// `import carmen`.
#[derive(Args, Clone, Debug)]
pub struct CarmenArgs {
    /// The recording
    pub input: PathBuf,
    /// The run log to write
    #[arg(short, long, value_name = "LOG")]
    pub output: PathBuf,
    /// Refuse a recording that has findings
    #[arg(long)]
    pub strict: bool,
    /// Replace a run log that is there
    #[arg(long)]
    pub force: bool,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
