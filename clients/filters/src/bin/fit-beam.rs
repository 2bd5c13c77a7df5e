//! `fit-beam`: fits the four parts of the beam model to a log.

use clap::Parser;
use rusty_clients::{ClientArgs, witness::run_witness_from};
use rusty_contract::Exit;
use rusty_filters::fit_beam::{FitBeam, Options};

/// Fit the four-part beam model to the readings of a log
///
/// A reading hits a wall of the map (hit), hits something nearer that the map does
/// not have (short), hits nothing (max), or has another cause (rand). The true poses
/// of the log and the map give the expected reading. Expectation maximisation
/// (Probabilistic Robotics, Table 6.2) estimates the shares of the four parts, the
/// spread of hit and the rate of short, each with its standard error. In a world
/// without people and chair legs the share of short is zero.
///
///   fit-beam --log run.log
///   fit-beam --log intel.log --map intel.yaml --json
#[derive(Parser)]
#[command(version, verbatim_doc_comment)]
struct Cli {
    #[command(flatten)]
    args: ClientArgs,

    #[command(flatten)]
    options: Options,
}

fn main() -> Exit {
    let Cli { args, options } = Cli::parse();
    run_witness_from(&args, |start, brief, _| FitBeam::new(start, brief, &options))
}
