//! `mcl`: Monte Carlo localisation.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::mcl::{Mcl, Options};

/// Localise in a known map with Monte Carlo localisation
///
/// Each particle is a possible pose. Odometry moves the particles, the laser weighs
/// them, and resampling prefers the heavy ones. Without an initial pose the particles
/// start everywhere, and the filter abstains until most of the belief is at one place.
/// It finds the robot again after a kidnapping.
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
    run_from(&args, |start| Mcl::of_start(start, &options))
}
