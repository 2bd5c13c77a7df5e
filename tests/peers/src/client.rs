//! A client's process, over the transports of the others.

use rustix::process::{Signal, getppid, set_parent_process_death_signal};

use crate::cli::ClientPlan;
use crate::error::BenchError;
use crate::transport;
use crate::work::{self, Mind};

/// Answers every frame, up to the last.
pub fn main(plan: &ClientPlan) -> Result<(), BenchError> {
    end_with_parent(plan.cell.parent, Signal::KILL)?;
    let config = work::config(1, plan.cell.scans)?;
    let mut mind = Mind::new(&config, plan.place);
    let cell = &plan.cell;
    let end = transport::client(cell.contender, cell.wait, &cell.folder)?;
    end.serve(Mind::ready(plan.place), Box::new(move |frame| mind.answer(frame)))
}

/// Has the kernel send this process `signal` when its parent ends.
pub fn end_with_parent(parent: u32, signal: Signal) -> Result<(), BenchError> {
    // A kernel that cannot do this leaves the process to its transport, which
    // fails when the other side has ended.
    let _ = set_parent_process_death_signal(Some(signal));
    match getppid().map(|pid| pid.as_raw_nonzero().get().unsigned_abs()) {
        Some(living) if living == parent => Ok(()),
        _ => Err(BenchError::Stopped),
    }
}
