//! `ekf`: follows the robot on a floor plan by its straight walls.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::ekf::{Ekf, Options};

/// Localise on a floor plan with an extended Kalman filter
///
/// The EKF (Probabilistic Robotics, chapter 7) predicts from the encoders, finds
/// the straight walls in each scan, matches them to the map, and corrects. It
/// needs the initial pose. Without a map it only predicts. It answers every tick
/// with a pose and a covariance, and reports the innovation (NIS) of each scan.
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
