//! `logger`: writes the run down as it happens.

use clap::Parser;
use rusty_clients::{ClientArgs, logger::Logger, run_witness};
use rusty_contract::Exit;

/// Writes the log of a run (run.log in the run's folder or in --out), or reads
/// one log and writes it again
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(flatten)]
    args: ClientArgs,
}

fn main() -> Exit {
    run_witness::<Logger>(&Cli::parse().args)
}
