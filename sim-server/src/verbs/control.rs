//! `control`: when the ticks of a run that goes on may happen.

use std::time::Duration;

use rusty_contract::config::check_seconds;
use rusty_contract::control::{ControlReply, ControlRequest};
use rusty_contract::{Exit, errln, outln};

use super::{Verbed, print_json};
use crate::cli::{ControlArgs, ControlVerb};

/// Says it to the run and prints where the run stands then.
///
/// # Errors
/// [`VerbError`](crate::error::VerbError) if there is no such run, or it does
/// not answer.
pub fn control(args: &ControlArgs) -> Verbed {
    check_seconds("--timeout", args.timeout)?;
    let request = match args.wish {
        ControlVerb::Status => ControlRequest::Status,
        ControlVerb::Pause => ControlRequest::Pause,
        ControlVerb::Step { ticks } => ControlRequest::Step(ticks),
        ControlVerb::Resume => ControlRequest::Resume,
        ControlVerb::Stop => ControlRequest::Stop,
    };
    match rusty_link::control(&args.run, request, Duration::from_secs_f64(args.timeout))? {
        ControlReply::Status(status) if args.json => print_json(&status),
        ControlReply::Status(status) => {
            let how = if status.paused { "paused" } else { "running" };
            outln!("{}: {how}, {} of {} ticks", status.run, status.ticks_done, status.ticks);
        }
        ControlReply::Refused(why) => {
            errln!("sim-server: run {}: {why}", args.run);
            return Ok(Exit::Failed);
        }
    }
    Ok(Exit::Done)
}
