//! `fit-motion`: fits the four α of the odometry motion model to a log.

use rusty_clients::{ClientArgs, run_recorder};
use rusty_contract::Exit;
use rusty_filters::fit_motion::FitMotion;

fn main() -> Exit {
    let (args, options) = ClientArgs::with_options();
    run_recorder(&args, |start, brief| Ok(FitMotion::new(start, brief, options)))
}
