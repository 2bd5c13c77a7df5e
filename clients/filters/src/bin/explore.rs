//! `explore`: drives to the frontiers of the map that it builds.

use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::{explore, gridmap::check_free};

fn main() -> Exit {
    let (args, options) = ClientArgs::with_options::<explore::Options>();
    run_from(&args, |start| {
        options.save.iter().try_for_each(|stem| check_free(&args, stem))?;
        Ok(explore::driver(start, options))
    })
}
