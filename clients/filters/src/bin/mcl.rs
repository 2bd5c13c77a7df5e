//! `mcl`: Monte Carlo localisation.

use rusty_contract::Exit;
use rusty_filters::mcl::{Mcl, Options};

fn main() -> Exit {
    rusty_clients::run(|start, options: Options| Mcl::of_start(start, &options))
}
