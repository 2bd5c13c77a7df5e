//! `conformance`: what a client program gets right of the protocol.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use rusty_contract::names::check_participant_name;
use rusty_contract::{Exit, FieldError, RunName, errln, outln};
use signal_hook::consts::{SIGINT, SIGTERM};

use super::{Verbed, print_json};
use crate::cli::ConformanceArgs;
use crate::error::VerbError;
use rusty_conformance::catalogue::{CATALOGUE, Check};
use rusty_conformance::fault::Halt;
use rusty_conformance::report::Report;
use rusty_conformance::{Kit, serve_until_killed};

/// Tests a client and prints a line per check.
///
/// # Errors
/// [`VerbError`] if the client cannot be started or there is no shared memory;
/// what the client gets wrong is an exit code.
pub fn conformance(args: &ConformanceArgs) -> Verbed {
    if args.list {
        list(args.json);
        return Ok(Exit::Done);
    }
    rusty_contract::config::check_seconds("--patience", args.patience)?;
    check_participant_name(&args.name)?;
    let wanted = wanted(&args.only)?;
    let kit = Kit {
        role: args.role,
        name: args.name.clone(),
        command: args.client.clone(),
        wait: args.wait,
        patience: Duration::from_secs_f64(args.patience),
        stop: Arc::default(),
    };
    if let Some(run) = &args.dies_as {
        return die_as(&kit, run);
    }
    for signal in [SIGINT, SIGTERM] {
        // No wait is without an end, so raising a flag is enough to stop.
        signal_hook::flag::register(signal, Arc::clone(&kit.stop))
            .map_err(VerbError::io(Path::new("signals")))?;
    }
    if !args.json {
        let (count, client) = (wanted.len(), args.client.join(" "));
        errln!("{count} checks of {client} as {}", kit.role);
    }
    let findings = kit.test(&wanted, args.jobs)?;
    let report = Report::new(&kit, wanted.len(), findings);
    if args.json {
        print_json(&report);
    } else {
        outln!("{report}");
    }
    Ok(report.exit())
}

/// The checks asked for, or all of them.
fn wanted(only: &[String]) -> Result<Vec<&'static Check>, FieldError> {
    for name in only {
        if !CATALOGUE.iter().any(|check| check.name == *name) {
            let names: Vec<&str> = CATALOGUE.iter().map(|check| check.name).collect();
            let remedy = format!("use one of: {}", names.join(", "));
            return Err(FieldError::new("--only", name, "is no check", remedy));
        }
    }
    let is_wanted = |check: &&Check| only.is_empty() || only.iter().any(|n| n == check.name);
    Ok(CATALOGUE.iter().filter(is_wanted).collect())
}

fn list(json: bool) {
    if json {
        let entry = |c: &Check| {
            serde_json::json!({
                "check": c.name, "done": c.done, "expected": c.expected, "rule": c.rule,
                "stands_in": c.stands_in, "roles": c.roles,
            })
        };
        print_json(&CATALOGUE.iter().map(entry).collect::<Vec<_>>());
        return;
    }
    for check in CATALOGUE {
        outln!("{}", check.name);
        outln!("  done      {}\n  expected  {}", check.done, check.expected);
        outln!("  the rule  {}\n  stands in {}", check.rule, check.stands_in);
    }
}

fn die_as(kit: &Kit, run: &RunName) -> Verbed {
    match serve_until_killed(kit, run) {
        Ok(()) => Ok(Exit::Lost),
        Err(Halt::Kit(error)) => Err((*error).into()),
        Err(Halt::Client(fault)) => {
            errln!("{fault}");
            Ok(Exit::Failed)
        }
        Err(Halt::Stopped) => Ok(Exit::Lost),
    }
}
