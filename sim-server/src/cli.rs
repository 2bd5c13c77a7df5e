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

/// Simulate a robot in lockstep with its estimators
///
/// The server publishes one world tick by tick into shared memory. The next tick
/// happens when every participant has answered.
#[derive(Parser)]
#[command(name = "sim-server", version, after_help = AFTER_HELP, propagate_version = true)]
pub struct Cli {
    #[command(subcommand)]
    pub verb: Verb,
}

const AFTER_HELP: &str = "\
Examples:
  sim-server launch                              the Apartment with dead reckoning
  sim-server launch --seed 7 --ticks 3000        another seed, one minute
  sim-server launch --add mine=./target/release/mine   your own filter as well
  sim-server verify runs/NAME/run.log            check that the run is bit-exact
  sim-server replay runs/NAME/run.log            same frames, same clients

Results go to stdout, diagnostics to stderr; --json prints one JSON document.
Exit codes: 0 done, 1 failed, 2 wrong usage, 3 finished but something was lost
(a participant, data, or the end of the run), 4 not bit-exact.";

#[derive(Subcommand)]
pub enum Verb {
    /// Run a scenario with its participants and score it
    Launch(LaunchArgs),
    /// Serve a scenario to participants that are started by hand
    Serve(ServeArgs),
    /// Replay a log to its participants in lockstep
    Replay(ReplayArgs),
    /// Simulate a logged run again and compare every bit
    Verify(VerifyArgs),
    /// Repeat a logged run with changes from a given tick
    Fork(ForkArgs),
    /// Run a scenario with many seeds and settings
    Sweep(SweepArgs),
    /// Compare two estimators by the tables of sweeps
    Compare(CompareArgs),
    /// Break down odometry error by source
    Budget(BudgetArgs),
    /// Calibrate wheels and wheelbase by the UMBmark square
    Umbmark(UmbmarkArgs),
    /// Find the first tick, field and bits where two logs differ
    Diff(DiffArgs),
    /// Describe a log or one of its ticks
    Info(InfoArgs),
    /// Export a log as trajectories for evo or as a table
    Export(ExportArgs),
    /// Split a log into a blind log and the key to its truth
    Seal(SealArgs),
    /// List, draw or scan worlds
    Worlds(WorldsArgs),
    /// Print the layout of the structs in shared memory
    Layout(JsonArgs),
    /// Convert the recording of a real robot into a run log
    #[command(subcommand)]
    Import(ImportVerb),
    /// Pause, step, resume or stop a running server
    Control(ControlArgs),
    /// Check bit-exactness and shared memory on this machine
    Doctor(JsonArgs),
    /// Test a client in any language against the protocol
    Conformance(ConformanceArgs),
    /// Measure performance against a baseline
    Bench(BenchArgs),
    /// List or remove the folders of runs
    Runs(RunsArgs),
    /// Remove the shared memory of runs that are dead
    Clean(JsonArgs),
    /// Take part in a benchmark (started by the benchmark)
    #[command(hide = true)]
    BenchPeer(BenchPeerArgs),
    /// Confine and execute a participant (started by the server)
    #[command(hide = true)]
    Confined(ConfinedArgs),
}

/// Options of every run.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
`{out}` in the COMMAND of --add is the run's folder. `control RUN step` or `resume`
continues a paused run. Waiting by `spin` occupies one core per process.")]
pub struct RunArgs {
    /// Name of the run [default: the scenario's and a random suffix]
    #[arg(long, value_name = "NAME")]
    pub run: Option<RunName>,
    /// Folder for log, scores and report [default: runs/NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the whole folder of a run that has ended
    #[arg(long)]
    pub force: bool,
    /// Simulated speed, max, real or a factor such as 2.5
    #[arg(long, default_value = "max", value_name = "P")]
    pub pace: Pace,
    /// Begin paused
    #[arg(long)]
    pub paused: bool,
    /// Waiting method of all processes, balanced, spin or block
    #[arg(long, default_value_t, value_name = "HOW")]
    pub wait: WaitPolicy,
    /// Time limit of an answer, s [default: the scenario's]
    #[arg(long, value_name = "SECONDS")]
    pub answer_timeout: Option<f64>,
    /// Time limit of joining, s [default: the scenario's]
    #[arg(long, value_name = "SECONDS")]
    pub join_timeout: Option<f64>,
    /// Add an estimator, and start it if COMMAND is given
    #[arg(long, value_name = "NAME[=COMMAND]")]
    pub add: Vec<String>,
    /// Confine started participants that hold no key to the truth
    /// [default: the scenario's] [possible values: none, if-possible, required]
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

/// The scenario and the changes to it.
#[derive(Args, Clone, Debug)]
pub struct ScenarioArgs {
    /// apartment, patrol, figure-eight, hallway, driver or a file
    #[arg(default_value = "apartment")]
    pub scenario: String,
    /// Seed of all noise, a number or random [default: the scenario's]
    #[arg(long, value_parser = seed::seed_or_random, allow_hyphen_values = true)]
    pub seed: Option<u64>,
    /// Number of ticks [default: the scenario's]
    #[arg(long)]
    pub ticks: Option<u64>,
    /// Change a field, e.g. robot.slip_std=0.05
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
    /// Log to replay
    pub log: PathBuf,
    /// Start no program; wait for participants started by hand
    #[arg(long)]
    pub attach: bool,
    /// The run.
    #[command(flatten)]
    pub run: RunArgs,
}

/// `verify`.
#[derive(Args, Clone, Debug)]
pub struct VerifyArgs {
    /// Log to read
    pub log: PathBuf,
    /// Run the estimators and the driver again and compare answers
    #[arg(long)]
    pub clients: bool,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// `diff`.
#[derive(Args, Clone, Debug)]
pub struct DiffArgs {
    /// First log
    pub a: PathBuf,
    /// Second log
    pub b: PathBuf,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// `info`.
#[derive(Args, Clone, Debug)]
pub struct InfoArgs {
    /// Log to read
    pub log: PathBuf,
    /// Show the tick of this index, counted from 0
    #[arg(long, value_name = "N")]
    pub tick: Option<u64>,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// `fork`.
#[derive(Args, Clone, Debug)]
pub struct ForkArgs {
    /// Log of a simulated run
    pub log: PathBuf,
    /// First tick that differs from the original run
    #[arg(long, value_name = "TICK")]
    pub at: u64,
    /// Change a field from that tick, e.g. robot.slip_std=0.05
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<String>,
    /// Seed from that tick, a number or random [default: the log's]
    #[arg(long, value_parser = seed::seed_or_random, allow_hyphen_values = true)]
    pub seed: Option<u64>,
    /// Total number of ticks [default: the log's]
    #[arg(long)]
    pub ticks: Option<u64>,
    /// The run.
    #[command(flatten)]
    pub run: RunArgs,
}

/// `seal`.
#[derive(Args, Clone, Debug)]
pub struct SealArgs {
    /// Log of a simulation or of a recording
    pub log: PathBuf,
    /// Blind log to write, without truth, seed and true parameters
    #[arg(short, long, value_name = "BLIND")]
    pub output: PathBuf,
    /// Key to write, with all that the blind log lacks (mode 0600)
    #[arg(long, value_name = "FILE")]
    pub key_file: PathBuf,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// `worlds`.
#[derive(Args, Clone, Debug)]
pub struct WorldsArgs {
    /// Built-in world or world file
    pub name: Option<String>,
    /// Scan without noise from this sensor pose, in m, m, rad
    #[arg(long, value_name = "X,Y,THETA", allow_hyphen_values = true, requires = "name")]
    pub scan: Option<String>,
    /// Number of beams of the scan over the full circle
    #[arg(long, default_value_t = 180)]
    pub beams: u32,
    /// Longest range of the scan, m
    #[arg(long, default_value_t = 8.0)]
    pub range_max: f64,
    /// Draw the world into this SVG file
    #[arg(long, value_name = "FILE", requires = "name")]
    pub svg: Option<PathBuf>,
    /// Replace an existing drawing
    #[arg(long, requires = "svg")]
    pub force: bool,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// Options of a verb that has only a form of output.
#[derive(Args, Clone, Debug)]
pub struct JsonArgs {
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// `confined`.
#[derive(Args, Clone, Debug)]
pub struct ConfinedArgs {
    /// Run whose shared memory the program may use
    #[arg(long, value_name = "NAME")]
    pub cell: RunName,
    /// Fail with `required` unless the kernel applies all rules
    #[arg(long, value_name = "HOW")]
    pub sandbox: Sandbox,
    /// File or folder that the program may read
    #[arg(long, value_name = "PATH")]
    pub file: Vec<PathBuf>,
    /// Folder in which the program may write
    #[arg(long, value_name = "PATH")]
    pub own_folder: Option<PathBuf>,
    /// Program to execute
    pub program: OsString,
    /// Arguments of the program
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pub args: Vec<OsString>,
}

#[derive(Subcommand)]
pub enum ImportVerb {
    /// Convert a CARMEN log (ODOM and FLASER), plain or gzip
    Carmen(CarmenArgs),
}

/// `import carmen`.
#[derive(Args, Clone, Debug)]
pub struct CarmenArgs {
    /// Recording to read
    pub input: PathBuf,
    /// Run log to write
    #[arg(short, long, value_name = "LOG")]
    pub output: PathBuf,
    /// Refuse a recording that has findings
    #[arg(long)]
    pub strict: bool,
    /// Replace an existing run log
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
