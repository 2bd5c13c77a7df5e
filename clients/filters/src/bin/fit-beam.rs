//! `fit-beam`: fits the four parts of the beam model to a log.

use rusty_clients::{ClientArgs, run_recorder};
use rusty_contract::Exit;
use rusty_filters::fit_beam::FitBeam;

fn main() -> Exit {
    let (args, options) = ClientArgs::with_options();
    run_recorder(&args, |start, brief| FitBeam::new(start, brief, options))
}
