//! `logger`: writes the log of a run.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use rusty_clients::{ClientArgs, parsed, run_recorder};
use rusty_contract::{Exit, Program, errln, outln, output};

use crate::{Logger, measure::Measure};

/// The programs of this package.
pub const PROGRAMS: &[Program] =
    &[Program::new("logger", "writes the log of a run, or rewrites a log", main)];

/// Write the log of a run, or read and rewrite a log
///
/// The log of a run is run.log in the run's folder or in --out.
#[derive(Parser)]
#[command(
    name = "logger",
    version,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true
)]
struct Cli {
    #[command(flatten)]
    args: ClientArgs,

    #[command(subcommand)]
    verb: Option<Verb>,
}

#[derive(Subcommand)]
enum Verb {
    /// Measure the speed of log writing against a plain file
    ///
    /// Writes the records of an artificial run several times, reads them, and removes
    /// them. The result is a ratio: log and plain file have the same length and are
    /// written in turns to the same folder under the same load.
    Measure(MeasureArgs),
}

#[derive(Args)]
struct MeasureArgs {
    /// Folder to write to
    #[arg(default_value = ".", value_name = "FOLDER")]
    folder: PathBuf,

    /// Number of ticks
    #[arg(long, default_value_t = 50_000, value_name = "N")]
    ticks: u64,

    /// Number of beams of the scan in each tick, 0 for no scans
    #[arg(long, default_value_t = 1080, value_name = "N")]
    beams: usize,

    /// Repetitions of each measurement, of which the fastest counts
    #[arg(long, default_value_t = 3, value_name = "N")]
    rounds: usize,

    /// Include the time until the disk has stored everything
    #[arg(long)]
    sync: bool,

    /// Print one JSON document on stdout
    #[arg(long)]
    json: bool,
}

fn main() -> Exit {
    let cli: Cli = parsed();
    match cli.verb {
        None => run_recorder(&cli.args, |start, brief| Logger::new(start, brief, &cli.args)),
        Some(Verb::Measure(args)) => measure(args),
    }
}

fn measure(args: MeasureArgs) -> Exit {
    let MeasureArgs { folder, ticks, beams, rounds, sync, json } = args;
    let exit = match (Measure { folder, ticks, beams, rounds, sync }).run() {
        Ok(found) => {
            let text = serde_json::to_string_pretty(&found).unwrap_or_default();
            outln!("{}", if json { text } else { found.to_string() });
            Exit::Done
        }
        Err(e) => {
            errln!("logger measure: {e}");
            e.exit()
        }
    };
    output::finish("logger measure", exit)
}
