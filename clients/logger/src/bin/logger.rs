//! `logger`: writes the run down as it happens.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use rusty_clients::{ClientArgs, run_witness};
use rusty_contract::{Exit, errln, outln, output};
use rusty_logger::{Logger, measure::Measure};

/// Writes the log of a run (run.log in the run's folder or in --out), or reads
/// one log and writes it again
#[derive(Parser)]
#[command(version, args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
struct Cli {
    #[command(flatten)]
    args: ClientArgs,

    #[command(subcommand)]
    verb: Option<Verb>,
}

#[derive(Subcommand)]
enum Verb {
    /// Measure how fast a log is written to a folder, beside a plain file of the
    /// same length there
    ///
    /// Writes the records of a run that never was, some times, reads them again,
    /// and leaves nothing. The ratio is what to look at: both files are
    /// written in turn, to the same folder, under the same load.
    Measure(MeasureArgs),
}

#[derive(Args)]
struct MeasureArgs {
    /// Where to write
    #[arg(default_value = ".", value_name = "FOLDER")]
    folder: PathBuf,

    /// How many ticks
    #[arg(long, default_value_t = 50_000, value_name = "N")]
    ticks: u64,

    /// Beams of the scan in each tick; 0: no scans
    #[arg(long, default_value_t = 1080, value_name = "N")]
    beams: usize,

    /// How often each way is gone; the fastest time of each counts
    #[arg(long, default_value_t = 3, value_name = "N")]
    rounds: usize,

    /// Let the clock run until the disk says that it has everything
    #[arg(long)]
    sync: bool,

    /// Print JSON
    #[arg(long)]
    json: bool,
}

fn main() -> Exit {
    let cli = Cli::parse();
    match cli.verb {
        None => run_witness::<Logger>(&cli.args),
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
