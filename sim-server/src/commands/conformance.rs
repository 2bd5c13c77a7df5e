//! `conformance`: test a client against the protocol.

use std::sync::Arc;
use std::time::Duration;

use anyhow::Result;
use clap::Args;
use rusty_conformance::catalogue::{CATALOGUE, Check};
use rusty_conformance::fault::Halt;
use rusty_conformance::report::Report;
use rusty_conformance::{Kit, serve_until_killed};
use rusty_contract::names::check_participant_name;
use rusty_contract::{Exit, FieldError, Role, RunName, errln, outln};
use rusty_link::WaitPolicy;

use super::arguments::Output;
use super::stop_flag;

#[derive(Args, Clone, Debug)]
#[command(after_help = "The client is started as a launcher would start it: --run, --name, \
    --wait, --launcher\nand --key-stdin are appended to its arguments.\n\
    Exit codes: 0 every check passed, 1 one failed, 2 wrong usage, 3 stopped (Ctrl-C).")]
pub struct ConformanceArgs {
    /// Role of the client [possible values: estimator, driver, scorer,
    /// logger, observer]
    #[arg(long, default_value_t = Role::Estimator, value_parser = rusty_conformance::role)]
    pub role: Role,
    /// Name of the client in the roster
    #[arg(long, default_value = "client", value_name = "NAME")]
    pub name: String,
    /// Time limit of each action of the client, s
    #[arg(long, default_value_t = 5.0, value_name = "SECONDS")]
    pub patience: f64,
    /// Waiting method of all processes, balanced, spin or block
    #[arg(long, default_value_t, value_name = "HOW")]
    pub wait: WaitPolicy,
    /// Run this check only; may be repeated
    #[arg(long, value_name = "CHECK")]
    pub only: Vec<String>,
    /// Number of checks that run at the same time
    #[arg(long, default_value_t = 2, value_name = "N")]
    pub jobs: usize,
    /// List the checks with actions, expected results and rules
    #[arg(long, conflicts_with_all = ["only", "client"])]
    pub list: bool,
    #[command(flatten)]
    pub output: Output,
    /// Serve this run until killed; read key and folder from stdin
    #[arg(long, hide = true, value_name = "RUN")]
    pub dies_as: Option<RunName>,
    /// Client and its arguments, after `--`
    #[arg(last = true, required_unless_present_any = ["list", "dies_as"], value_name = "CLIENT")]
    pub client: Vec<String>,
}

pub fn run(args: &ConformanceArgs) -> Result<Exit> {
    if args.list {
        list(args.output);
        return Ok(Exit::Done);
    }
    rusty_contract::config::check_seconds("--patience", args.patience)?;
    check_participant_name(&args.name)?;
    let wanted = wanted(&args.only)?;
    let mut kit = Kit {
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
    // Every wait has an end, so a flag is enough to stop.
    kit.stop = stop_flag()?;
    if !args.output.json {
        let (count, client) = (wanted.len(), args.client.join(" "));
        errln!("{count} checks of {client} as {}", kit.role);
    }
    let findings = kit.test(&wanted, args.jobs)?;
    let report = Report::new(&kit, wanted.len(), findings);
    args.output.print(&report);
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

fn list(output: Output) {
    output.print_with(&CATALOGUE, || {
        for check in CATALOGUE {
            outln!("{check}");
        }
    });
}

fn die_as(kit: &Kit, run: &RunName) -> Result<Exit> {
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
