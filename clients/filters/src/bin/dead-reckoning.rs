//! `dead-reckoning`: integrates the encoders.

use rusty_clients::dead_reckoning::{DeadReckoning, Options};
use rusty_contract::Exit;

fn main() -> Exit {
    rusty_clients::run(|start, options: Options| {
        Ok(DeadReckoning::of_start(start).with_options(options))
    })
}
