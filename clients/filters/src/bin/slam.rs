//! `slam`: localises and maps without a given map.

use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::gridmap::check_free;
use rusty_filters::slam::{Slam, SlamOptions};

fn main() -> Exit {
    let (args, options) = ClientArgs::with_options::<SlamOptions>();
    run_from(&args, |start| {
        options.save_map.iter().try_for_each(|stem| check_free(&args, stem))?;
        Ok(Slam::new(start, &options))
    })
}
