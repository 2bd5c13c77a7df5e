//! `clean`: remove the shared memory of dead runs.

use anyhow::Result;
use rusty_contract::{Exit, outln};
use rusty_link::{Domain, RunState};
use serde_json::json;

use super::arguments::Output;

pub fn run(output: &Output) -> Result<Exit> {
    let swept: Vec<String> = Domain::sweep_dead()?.iter().map(ToString::to_string).collect();
    let alive: Vec<(String, u32)> = Domain::list()?
        .into_iter()
        .filter_map(|(run, state)| match state {
            RunState::Alive { pid } => Some((run.to_string(), pid)),
            RunState::Dead => None,
        })
        .collect();
    let runs: Vec<_> = alive.iter().map(|(run, pid)| json!({ "run": run, "pid": pid })).collect();
    output.print_with(&json!({ "removed": swept, "alive": runs }), || {
        if swept.is_empty() {
            outln!("nothing to remove");
        }
        swept.iter().for_each(|what| outln!("removed {what}"));
        alive.iter().for_each(|(run, pid)| outln!("alive   {run} (process {pid})"));
    });
    Ok(Exit::Done)
}
