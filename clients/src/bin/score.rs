//! `score`: compares estimates with the truth, and reports on the run.

use clap::Parser;
use rusty_clients::{ClientArgs, run_witness, scorer::Scorer};
use rusty_contract::Exit;

/// Scores every estimator of a run or of a log against the truth: a table on
/// stdout, score.json, report.html (a page that needs nothing else), report.svg
/// and report.png in the run's folder or in --out
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(flatten)]
    args: ClientArgs,
}

fn main() -> Exit {
    run_witness::<Scorer>(&Cli::parse().args)
}
