//! `goto`: drives to waypoints.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::ekf::{self, Ekf};
use rusty_filters::goto::{Goto, Options};

/// Drive to a list of waypoints on a floor plan
///
/// The driver uses its own pose estimate (an EKF on straight walls, like `ekf`). The
/// default waypoints are the middle of every room of the Apartment and back. It sends
/// no command that could touch, before the next scan, a wall that its laser has hit.
/// It does not see walls between the beams, and it assumes that commands take effect
/// within the time of one scan. At the end it prints the number of waypoints reached
/// and of ticks used. The scenario needs a script of kind "driver"; the role is driver.
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
