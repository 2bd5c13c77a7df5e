//! `bayes-hallway`: localises the robot in a corridor by its doors.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::bayes_hallway::{BayesHallway, Options};

/// Localise in a corridor by its doors with a histogram filter
///
/// The filter (Probabilistic Robotics, chapters 2 and 4) is for a corridor along x
/// with recessed doors, the world "hallway". Its belief is over cells along the
/// corridor and over both headings, and is uniform at the start. It needs the map
/// and no initial pose. After one door the belief has a peak at each door; the
/// distance to the next door selects one.
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
