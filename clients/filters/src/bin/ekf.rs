//! `ekf`: follows the robot on a floor plan by its straight walls.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::ekf::{Ekf, Options};

/// EKF localisation (Probabilistic Robotics, chapter 7): predicts by the wheels,
/// finds the straight walls in each scan, matches them to the map that it was
/// given, and corrects. It must be told where the robot starts; without a map it
/// only predicts. It answers with a pose and a covariance in every tick, and says
/// of each scan how surprising it was
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(flatten)]
    args: ClientArgs,

    #[command(flatten)]
    options: Options,
}

fn main() -> Exit {
    let Cli { args, options } = Cli::parse();
    run_from(&args, |start| Ekf::new(start, &options))
}
