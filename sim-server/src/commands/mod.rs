//! The commands, a module for each.

mod arguments;
mod bench;
mod benchmark;
mod budget;
mod clean;
mod compare;
mod confined;
mod conformance;
mod control;
mod diff;
mod doctor;
mod export;
mod fork;
mod import;
mod info;
mod launch;
mod layout;
mod manual;
mod programs;
mod replay;
mod report;
mod runs;
mod seal;
mod session;
mod sweep;
mod umbmark;
mod verify;
mod watch;
mod worlds;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Context as _, Result};
use clap::{CommandFactory as _, Parser, Subcommand};
use rusty_contract::{Exit, FieldError, LogHeader, NameError, errln};
use signal_hook::consts::{SIGINT, SIGTERM};

/// Simulate a robot in lockstep with its estimators
///
/// The server publishes one world tick by tick into shared memory. The next tick
/// happens when every participant has answered.
#[derive(Parser)]
#[command(name = "sim-server", version, after_help = AFTER_HELP, propagate_version = true)]
pub struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

const AFTER_HELP: &str = "\
Examples:
  sim-server launch                              the Apartment with dead reckoning
  sim-server launch --watch                      the same, live in a browser
  sim-server launch --seed 7 --ticks 3000        another seed, one minute
  sim-server launch --add mine=./target/release/mine   your own filter as well
  sim-server verify runs/NAME/run.log            check that the run is bit-exact
  sim-server replay runs/NAME/run.log            same frames, same clients

Results go to stdout, diagnostics to stderr; --json prints one JSON document.
Exit codes: 0 done, 1 failed, 2 wrong usage, 3 finished but something was lost
(a participant, data, or the end of the run), 4 not bit-exact.";

#[derive(Subcommand)]
enum Verb {
    /// Run a scenario with its participants and score it
    Launch(launch::LaunchArgs),
    /// Serve a scenario to participants that are started by hand
    Serve(launch::LaunchArgs),
    /// Replay a log to its participants in lockstep
    Replay(replay::ReplayArgs),
    /// Simulate a logged run again and compare every bit
    Verify(verify::VerifyArgs),
    /// Repeat a logged run with changes from a given tick
    Fork(fork::ForkArgs),
    /// Run a scenario with many seeds and settings
    Sweep(sweep::SweepArgs),
    /// Compare two estimators by the tables of sweeps
    Compare(compare::CompareArgs),
    /// Break down odometry error by source
    Budget(budget::BudgetArgs),
    /// Calibrate wheels and wheelbase by the UMBmark square
    Umbmark(umbmark::UmbmarkArgs),
    /// Find the first tick, field and bits where two logs differ
    Diff(diff::DiffArgs),
    /// Describe a log or one of its ticks
    Info(info::InfoArgs),
    /// Export a log as trajectories for evo or as a table
    Export(export::ExportArgs),
    /// Split a log into a blind log and the key to its truth
    Seal(seal::SealArgs),
    /// List, draw, scan or check worlds
    Worlds(worlds::WorldsArgs),
    /// Print the layout of the structs in shared memory
    Layout(arguments::Output),
    /// Convert the recording of a real robot into a run log
    #[command(subcommand)]
    Import(import::ImportFormat),
    /// Pause, step, resume or stop a running server
    Control(control::ControlArgs),
    /// Check bit-exactness and shared memory on this machine
    Doctor(arguments::Output),
    /// Test a client in any language against the protocol
    Conformance(conformance::ConformanceArgs),
    /// Measure performance against a baseline
    Bench(bench::BenchArgs),
    /// Run filters through a fixed suite and compare results
    #[command(subcommand)]
    Benchmark(benchmark::BenchmarkStep),
    /// List, compare or remove the folders of runs
    Runs(runs::RunsArgs),
    /// Remove the shared memory of runs that are dead
    Clean(arguments::Output),
    /// List the clients in this binary or link their names
    Programs(programs::ProgramsArgs),
    /// Print the completions of a shell
    Completions(manual::CompletionsArgs),
    /// Write the pages of these commands for `man`
    Man(manual::ManArgs),
    /// Take part in a benchmark (started by the benchmark)
    #[command(hide = true)]
    BenchPeer(bench::BenchPeerArgs),
    /// Confine and execute a participant (started by the server)
    #[command(hide = true)]
    Confined(confined::ConfinedArgs),
}

impl Cli {
    /// Runs the command and returns its exit code; an error goes to stderr.
    pub fn run(self) -> Exit {
        let done = match self.verb {
            Verb::Launch(args) => launch::launch(&args),
            Verb::Serve(args) => launch::serve(&args),
            Verb::Replay(args) => replay::run(&args),
            Verb::Verify(args) => verify::run(&args),
            Verb::Fork(args) => fork::run(&args),
            Verb::Sweep(args) => sweep::run(&args),
            Verb::Compare(args) => compare::run(&args),
            Verb::Budget(args) => budget::run(&args),
            Verb::Umbmark(args) => umbmark::run(&args),
            Verb::Diff(args) => diff::run(&args),
            Verb::Info(args) => info::run(&args),
            Verb::Export(args) => export::run(&args),
            Verb::Seal(args) => seal::run(&args),
            Verb::Worlds(args) => worlds::run(&args),
            Verb::Layout(args) => layout::run(&args),
            Verb::Import(args) => import::run(&args),
            Verb::Control(args) => control::run(&args),
            Verb::Doctor(args) => doctor::run(&args),
            Verb::Conformance(args) => conformance::run(&args),
            Verb::Bench(args) => bench::run(&args),
            Verb::Benchmark(step) => benchmark::run(&step),
            Verb::Runs(args) => runs::run(&args),
            Verb::Clean(args) => clean::run(&args),
            Verb::Programs(args) => programs::run(&args),
            Verb::Completions(args) => manual::completions(&args, Self::command()),
            Verb::Man(args) => manual::man(&args, Self::command()),
            Verb::BenchPeer(args) => bench::run_peer(&args),
            Verb::Confined(args) => confined::run(&args),
        };
        done.unwrap_or_else(|error| {
            errln!("sim-server: {}", message(&error));
            exit_code(&error)
        })
    }
}

/// The name of this program in the logs that it writes.
const WRITER: &str = concat!("sim-server ", env!("CARGO_PKG_VERSION"));

/// An argument with a value that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct WrongUsage(String);

/// Returns the messages of an error and its causes, except those that are part of
/// the message before.
fn message(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !text.contains(&cause) {
            text += &format!(": {cause}");
        }
    }
    text
}

/// Returns the exit code of an error: wrong input is wrong usage.
fn exit_code(error: &anyhow::Error) -> Exit {
    macro_rules! of {
        ($($kind:ty),+) => {
            $(if let Some(error) = error.downcast_ref::<$kind>() {
                return error.exit();
            })+
        };
    }
    of!(
        rusty_bench::BenchError,
        rusty_bench::page::PageError,
        rusty_engine::run::RunError,
        rusty_logs::drivers::DriversError,
        rusty_logs::export::ExportError,
        rusty_logs::folder::FolderError,
        rusty_logs::fork::ForkError,
        rusty_logs::seal::SealError,
        rusty_study::benchmark::BenchmarkError,
        rusty_study::sweep::SweepError,
        rusty_study::versus::VersusError
    );
    let is_usage = error.is::<WrongUsage>()
        || error.is::<FieldError>()
        || error.is::<NameError>()
        || error.is::<rusty_engine::scenario_file::SetupError>()
        || error.is::<rusty_floorplan::FloorplanError>()
        || error.is::<rusty_sim::SimError>()
        || error.is::<rusty_study::umbmark::LapError>();
    if is_usage { Exit::Usage } else { Exit::Failed }
}

/// Returns a flag that Ctrl-C and SIGTERM raise.
fn stop_flag() -> Result<Arc<AtomicBool>> {
    let stop = Arc::<AtomicBool>::default();
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop)).context("signals")?;
    }
    Ok(stop)
}

/// Warns that `reader` can find the run's seed by trying, and with it the truth.
fn warn_of_guessable_seed(header: &LogHeader, reader: &str) {
    if let Some(seed) = header.guessable_seed() {
        errln!(
            "seed {seed} is below 2^40: {reader} can find it by trying, and it gives the truth; \
             make the run with --seed random"
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        rusty_clients::with_negative_numbers(Cli::command()).debug_assert();
    }
}
