//! `sim-server`: runs, replays, checks and studies simulations.

mod commands;

use clap::Parser as _;
use rusty_contract::{Exit, output};

fn main() -> Exit {
    rusty_engine::run::prepare_process();
    output::finish("sim-server", commands::Cli::parse().run())
}
