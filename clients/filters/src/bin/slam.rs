//! `slam`: localises and maps without a given map.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::gridmap::check_free;
use rusty_filters::slam::{Slam, SlamOptions};

/// Localise and map with a pose graph, without a given map
///
/// Key scans are the nodes of the graph, and matches between them are its edges. When
/// the robot returns to a known place, the loop is closed and the whole path is
/// corrected (Probabilistic Robotics, chapter 11; Grisetti et al. 2010). With
/// --save-map the map is written at the end.
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
