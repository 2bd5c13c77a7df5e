//! `dead-reckoning`: integrates the encoders.

use rusty_clients::dead_reckoning::DeadReckoning;
use rusty_contract::Exit;

fn main() -> Exit {
    rusty_clients::run(|start, ()| Ok(DeadReckoning::of_start(start)))
}
