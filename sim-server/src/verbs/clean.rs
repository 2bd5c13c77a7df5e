//! `clean`: remove what dead runs left; living ones stay.

use rusty_contract::{Exit, outln};
use rusty_link::{Domain, RunState};
use serde_json::json;

use super::{Verbed, print_json};
use crate::cli::JsonArgs;

/// Sweeps dead runs of this user.
///
/// # Errors
/// [`VerbError`](crate::error::VerbError) names what could not be removed.
pub fn clean(args: &JsonArgs) -> Verbed {
    let swept: Vec<String> = Domain::sweep_dead()?.iter().map(ToString::to_string).collect();
    let alive: Vec<(String, u32)> = Domain::list()?
        .into_iter()
        .filter_map(|(run, state)| match state {
            RunState::Alive { pid } => Some((run.to_string(), pid)),
            RunState::Dead => None,
        })
        .collect();
    if args.json {
        let alive: Vec<_> =
            alive.iter().map(|(run, pid)| json!({ "run": run, "pid": pid })).collect();
        print_json(&json!({ "removed": swept, "alive": alive }));
        return Ok(Exit::Done);
    }
    if swept.is_empty() {
        outln!("nothing to remove");
    }
    for what in &swept {
        outln!("removed {what}");
    }
    for (run, pid) in alive {
        outln!("alive   {run} (process {pid})");
    }
    Ok(Exit::Done)
}
