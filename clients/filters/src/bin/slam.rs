//! `slam`: where the robot is and what the place looks like, without a map.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::slam::{Slam, SlamOptions};

/// Odometry by matching scans: each scan is laid on the walls of a key scan
/// (point-to-line ICP), and the wheels say where to begin and how far to trust
/// it. Needs no map. Drifts, but from key scan to key scan only, and says by how
/// much
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(flatten)]
    args: ClientArgs,

    #[command(flatten)]
    options: SlamOptions,
}

fn main() -> Exit {
    let Cli { args, options } = Cli::parse();
    run_from(&args, |start| Ok(Slam::new(start, &options)))
}
