//! `fit-motion`: fits the four α of the odometry motion model to a log.

use clap::Parser;
use rusty_clients::{ClientArgs, witness::run_witness_from};
use rusty_contract::Exit;
use rusty_filters::fit_motion::{FitMotion, Options};

/// Fit α₁ to α₄ of the odometry motion model to a log
///
/// The log must have true poses. The model (Probabilistic Robotics, Table 5.6) gives
/// the error of odometry after a rotation and after a translation. The output has the
/// maximum-likelihood values, their standard errors, and the flags for a filter. The
/// values are for motions of one tick and depend on the length of a tick. A value
/// that the log does not determine has no flag; keep the previous one.
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
