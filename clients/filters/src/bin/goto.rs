//! `goto`: drives to one place after the other.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::ekf::{self, Ekf};
use rusty_filters::goto::{Goto, Options};

/// Drives to one place after the other on the floor plan that it is given, by its
/// own estimate of where it is (an EKF on straight walls, that of `ekf`); in the
/// Apartment, unless told otherwise, to the middle of every room and back. No command
/// is given that could touch, before the next scan, a wall that its laser has met;
/// where no beam points it sees nothing, and it counts on being answered within a
/// scan. Says at the end how many places it reached and in how many ticks. For a
/// scenario with a script of kind "driver"; its role is driver
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(flatten)]
    args: ClientArgs,

    #[command(flatten)]
    options: Options,

    #[command(flatten)]
    ekf: ekf::Options,
}

fn main() -> Exit {
    let Cli { args, options, ekf } = Cli::parse();
    run_from(&args, |start| Goto::new(start, &options, |start| Ekf::new(start, &ekf)))
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
