//! `fit-beam`: the four parts of a laser's readings, from a log.

use clap::Parser;
use rusty_clients::{ClientArgs, witness::run_witness_from};
use rusty_contract::Exit;
use rusty_filters::fit_beam::{FitBeam, Options};

/// Fits the four-part beam model to the readings of a log
///
/// A reading met what the map has there (hit), something nearer that the map does
/// not know (short), nothing (max), or it is inexplicable (rand). With the true
/// poses of a log the map says what each reading should have been, and expectation
/// maximisation (Probabilistic Robotics, Table 6.2) which of the four each was:
/// their shares, the spread of hit and the rate of short, each with its standard
/// error. In a world without people and chair legs nothing is short, and the fit
/// says so.
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
