//! `wander`: drives through free space by the laser only.

use rusty_contract::Exit;
use rusty_filters::wander;

fn main() -> Exit {
    rusty_clients::run(|start, options| Ok(wander::driver(start, options)))
}
