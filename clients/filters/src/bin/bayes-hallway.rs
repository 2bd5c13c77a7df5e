//! `bayes-hallway`: finds the robot in a corridor by its doors.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::bayes_hallway::{BayesHallway, Options};

/// Histogram filter (Probabilistic Robotics, chapters 2 and 4) for a corridor
/// along x with recessed doors, the place "hallway": a belief over cells along it
/// and over both headings, uniform at the start. It needs the map and no initial
/// pose. Passing a door leaves a peak at each of them; which it was, the way to
/// the next one tells
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
    run_from(&args, |start| BayesHallway::new(start, &options))
}
