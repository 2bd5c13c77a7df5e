//! `control`: pause, step, resume or stop a running server.

use std::time::Duration;

use anyhow::{Result, anyhow};
use clap::{Args, Subcommand};
use rusty_contract::config::check_seconds;
use rusty_contract::control::{ControlReply, ControlRequest};
use rusty_contract::{Exit, RunName, errln, outln};
use rusty_engine::run::Pace;
use rusty_link::LinkError;

use super::arguments::Output;

/// How long the state is waited for where the reply to a step did not come.
const STATUS_TIME: Duration = Duration::from_secs(2);

#[derive(Args, Clone, Debug)]
#[command(after_help = "\
No control request changes a bit of the run. `step` replies when its ticks are
complete. The log gets a tick when the next one begins or the run ends.")]
pub struct ControlArgs {
    /// Name of the run, as in the first line of the server
    pub run: RunName,
    /// Request to send
    #[command(subcommand)]
    pub request: ControlVerb,
    /// Time limit of the reply, s
    #[arg(long, default_value_t = 60.0, value_name = "SECONDS", global = true)]
    pub timeout: f64,
    /// Print one JSON document on stdout
    #[arg(long, global = true)]
    pub json: bool,
}

#[derive(Subcommand, Clone, Copy, Debug)]
pub enum ControlVerb {
    /// Print the state of the run
    Status,
    /// Pause after the current tick
    Pause,
    /// Advance by TICKS ticks, then pause
    Step {
        /// Number of ticks
        #[arg(default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
        ticks: u64,
    },
    /// Resume at the previous pace
    Resume,
    /// Change the pace, max, real or a factor such as 2.5
    Pace {
        /// New pace
        pace: Pace,
    },
    /// Stop the run after the current tick, like Ctrl-C
    Stop,
}

pub fn run(args: &ControlArgs) -> Result<Exit> {
    check_seconds("--timeout", args.timeout)?;
    let request = match args.request {
        ControlVerb::Status => ControlRequest::Status,
        ControlVerb::Pause => ControlRequest::Pause,
        ControlVerb::Step { ticks } => ControlRequest::Step(ticks),
        ControlVerb::Resume => ControlRequest::Resume,
        ControlVerb::Pace { pace: Pace::Max } => ControlRequest::Pace(None),
        ControlVerb::Pace { pace: Pace::Factor(factor) } => ControlRequest::Pace(Some(factor)),
        ControlVerb::Stop => ControlRequest::Stop,
    };
    let timeout = Duration::from_secs_f64(args.timeout);
    let reply = match rusty_link::control(&args.run, request, timeout) {
        Err(error @ LinkError::NoAnswer { .. }) if matches!(request, ControlRequest::Step(_)) => {
            return Err(still_stepping(args).unwrap_or_else(|| error.into()));
        }
        reply => reply?,
    };
    match reply {
        ControlReply::Status(status) => Output { json: args.json }.print_with(&status, || {
            let how = match args.request {
                ControlVerb::Stop => "stopping",
                _ if status.paused => "paused",
                _ => "running",
            };
            outln!("{}: {how}, {} of {} ticks", status.run, status.ticks_done, status.ticks);
        }),
        ControlReply::Refused(why) => {
            errln!("sim-server: run {}: {why}", args.run);
            return Ok(Exit::Failed);
        }
        // The reply to a request that is not made here.
        ControlReply::Start(_) => {}
    }
    Ok(Exit::Done)
}

/// Steps that take longer than the reply may: what there is to say if the server runs.
fn still_stepping(args: &ControlArgs) -> Option<anyhow::Error> {
    let status = rusty_link::control(&args.run, ControlRequest::Status, STATUS_TIME).ok()?;
    let ControlReply::Status(status) = status else { return None };
    let (run, done, ticks, seconds) = (&status.run, status.ticks_done, status.ticks, args.timeout);
    Some(anyhow!(
        "not complete within {seconds} s; the steps go on, with {done} of {ticks} ticks \
         done; `sim-server control {run} status` tells when they are, a larger --timeout waits \
         for it"
    ))
}
