//! `sim-server`: runs, replays, checks and studies simulations. Started under the name of
//! a client, it is that client.

mod commands;
mod names;
mod programs;

use rusty_contract::{Exit, errln, output};
use rusty_engine::executable::{Executable, declare_built_in};

fn main() -> Exit {
    let mut words = std::env::args_os();
    if let Some(client) = words.next().as_deref().and_then(programs::named) {
        return programs::run(client);
    }
    declare_built_in(names::NAMES);
    let client = words.next().and_then(|word| Executable::built_in(word.to_str()?));
    if let Some(client) = client {
        let Err(error) = programs::become_client(&client, words);
        errln!("sim-server: starting {client} failed: {error}");
        return Exit::Failed;
    }
    rusty_engine::run::prepare_process();
    output::finish("sim-server", rusty_clients::parsed::<commands::Cli>().run())
}
