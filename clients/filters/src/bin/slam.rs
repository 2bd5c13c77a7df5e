//! `slam`: where the robot is and what the place looks like, without a map.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::gridmap::check_free;
use rusty_filters::slam::{Slam, SlamOptions};

/// Finds out where it is and what the place looks like, without a map: key scans
/// are the nodes of a graph, matches between them its edges; where the robot comes
/// back to a place that it knows, the whole path is bent into one piece
/// (Probabilistic Robotics, chapter 11; Grisetti et al. 2010). Writes its map at the
/// end with --save-map
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
    run_from(&args, |start| {
        options.save_map.iter().try_for_each(|stem| check_free(&args, stem))?;
        Ok(Slam::new(start, &options))
    })
}
