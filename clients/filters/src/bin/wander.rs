//! `wander`: drives about by the laser alone.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::wander::{Options, Wander};

/// Drives about without a map: straight on while there is room, then some other
/// free direction. No command is given that could touch, before the next scan, a wall
/// that its laser has met; where no beam points it sees nothing, and it counts on
/// being answered within a scan. For a scenario with a script of kind "driver"; its
/// role is driver. Where it is told the initial pose it also answers where it believes
/// to be, which is dead reckoning
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
    run_from(&args, |start| Ok(Wander::new(start, &options)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn the_command_line_has_no_word_twice() {
        Cli::command().debug_assert();
    }
}
