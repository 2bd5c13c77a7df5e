//! `mcl`: Monte Carlo localisation.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::mcl::{Mcl, Options};

/// Monte Carlo localisation: finds the robot in a known map with particles, and
/// finds it again when it was carried away.
///
/// Each particle is a pose that is possible. The wheels move it, the laser
/// weighs it, and the heavy ones are drawn again and again. Without an initial pose it
/// begins with particles everywhere, and abstains until most of the belief is in
/// one place
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
