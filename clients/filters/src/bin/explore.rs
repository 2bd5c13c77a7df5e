//! `explore`: drives to where its own map ends, until it ends nowhere.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::OdometryNoise;
use rusty_filters::explore::{Explore, Options};
use rusty_filters::gridmap::check_free;
use rusty_filters::scan_match::{ScanMatch, ScanMatchOptions};

/// Explores: makes a map of what its laser sees, drives to the nearest edge of
/// it, and again, until no edge is left that it can get to (Yamauchi 1997). Where
/// it is, scan matching says, that of `scan-match`. It
/// uses no map that it may be given. For a scenario with a script of kind
/// "driver"; its role is driver. Writes its map at the end with --save
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(flatten)]
    args: ClientArgs,

    #[command(flatten)]
    options: Options,

    #[command(flatten)]
    wheels: OdometryNoise,
}

fn main() -> Exit {
    let Cli { args, options, wheels } = Cli::parse();
    let matching = ScanMatchOptions { wheels, ..ScanMatchOptions::default() };
    run_from(&args, |start| {
        options.save.iter().try_for_each(|stem| check_free(&args, stem))?;
        Ok(Explore::new(start, &options, ScanMatch::new(start, &matching)))
    })
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
