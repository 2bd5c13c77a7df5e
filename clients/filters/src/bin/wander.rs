//! `wander`: drives through free space by the laser only.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::wander::{Options, Wander};

/// Drive through free space without a map
///
/// The driver goes straight while the way is free, then turns to another free
/// direction. It sends no command that could touch, before the next scan, a wall that
/// its laser has hit. It does not see walls between the beams, and it assumes that
/// commands take effect within the time of one scan. The scenario needs a script of
/// kind "driver"; the role is driver. If it gets the initial pose, it also answers
/// with dead reckoning.
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
