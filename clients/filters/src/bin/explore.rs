//! `explore`: drives to the frontiers of the map that it builds.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::OdometryNoise;
use rusty_filters::explore::{Explore, Options};
use rusty_filters::gridmap::check_free;
use rusty_filters::scan_match::{ScanMatch, ScanMatchOptions};

/// Explore an unknown world by its frontiers
///
/// The driver maps what its laser sees and drives to the nearest frontier of the
/// map, until no reachable frontier is left (Yamauchi 1997). It localises by scan
/// matching, like `scan-match`, and does not use the map of the scenario. The
/// scenario needs a script of kind "driver"; the role is driver. With --save it
/// writes its map at the end.
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
