//! `sim-server`: the process that owns time.

use rusty_contract::Exit;

fn main() -> Exit {
    sim_server::cli::main()
}
