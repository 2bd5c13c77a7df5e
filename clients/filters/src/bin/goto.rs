//! `goto`: drives to waypoints.

use rusty_contract::Exit;
use rusty_filters::goto;

fn main() -> Exit {
    rusty_clients::run(goto::driver)
}
