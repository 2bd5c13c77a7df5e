//! `budget`: how much of the odometry's error comes from where.

use std::io::IsTerminal as _;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rusty_contract::{Exit, FieldError, ScriptConfig, errln, outln};
use signal_hook::consts::{SIGINT, SIGTERM};

use super::{Verbed, print_json};
use crate::cli::BudgetArgs;
use crate::error::VerbError;
use rusty_engine::scenario_file;
use rusty_study::budget::budget as make;

/// The most seeds: their figures are in memory together.
const MOST_SEEDS: u64 = 10_000_000;

/// Makes the runs and prints the table.
///
/// # Errors
/// [`VerbError`] if the scenario cannot be used.
pub fn budget(args: &BudgetArgs) -> Verbed {
    let mut loaded = scenario_file::load(&args.scenario, &args.changes)?;
    loaded.scenario.ticks = args.ticks.unwrap_or(loaded.scenario.ticks);
    let config = loaded.config()?;
    if matches!(config.script, ScriptConfig::Driver {}) {
        let remedy = "choose a scenario with a script of its own, or --set script='{ kind = \
                      \"straight\", v_m_s = 0.5 }'";
        let problem = "needs a client to drive it, and none takes part here";
        return Err(FieldError::new("script.kind", "driver", problem, remedy).into());
    }
    if args.seeds.count() > MOST_SEEDS {
        let remedy = format!("use at most {MOST_SEEDS}");
        return Err(FieldError::new("--seeds", args.seeds, "are too many", remedy).into());
    }
    let stop = Arc::<AtomicBool>::default();
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop))
            .map_err(VerbError::io(Path::new("signals")))?;
    }
    let shown = !(args.quiet || args.json) && std::io::stderr().is_terminal();
    let mut at = String::new();
    let report = make(&config, args.seeds, &mut |row| {
        if shown && row != at {
            errln!("{row} …");
            row.clone_into(&mut at);
        }
        !stop.load(Ordering::Relaxed)
    })?;
    match report {
        Some(report) if args.json => print_json(&report),
        Some(report) => outln!("{report}"),
        None => {
            errln!("sim-server: stopped; a budget over fewer --seeds takes less time");
            return Ok(Exit::Lost);
        }
    }
    Ok(Exit::Done)
}
