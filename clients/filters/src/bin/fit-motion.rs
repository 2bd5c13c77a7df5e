//! `fit-motion`: the four α of the odometry motion model, from a log.

use clap::Parser;
use rusty_clients::{ClientArgs, witness::run_witness_from};
use rusty_contract::Exit;
use rusty_filters::fit_motion::{FitMotion, Options};

/// Fits α₁ to α₄ of the odometry motion model to a log with true poses
///
/// The model (Probabilistic Robotics, Table 5.6) says how far odometry is off after
/// a turn and after a way; the log says how far it was. What is printed are the most
/// likely numbers, their standard errors, and the flags to give to a filter. The
/// numbers are those of motions of one tick: with another length of a tick they are
/// others. A number that the log does not tell has no flag: keep what you believed.
///
///   fit-motion --log run.log
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
    run_witness_from(&args, |start, brief, _| Ok(FitMotion::new(start, brief, options)))
}
