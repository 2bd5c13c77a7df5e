//! The transport of ours without our protocol: iceoryx2 alone, with the frame,
//! the answers and the way of waiting of a run.
//!
//! No world, no seal, no digest: what `ours` takes beyond this is what the
//! laboratory costs. It is no contest for the others, which do all the work.

use rustix::process::Signal;
use rusty_contract::RunName;
use rusty_link::Domain;
use rusty_link::raw::{RawServer, serve_raw};

use crate::cli::{ClientPlan, ServerPlan};
use crate::client::end_with_parent;
use crate::error::BenchError;
use crate::meter::{Measured, Meter, run_ticks};
use crate::server::{start_clients, watch};

/// The run's name is the server's process, so that clients know it.
fn run_of(pid: u32) -> Result<RunName, BenchError> {
    RunName::new(&format!("peers-raw-{pid}")).map_err(|e| BenchError::Ours(e.to_string()))
}

/// One measurement.
pub fn measure(plan: &ServerPlan) -> Result<Measured, BenchError> {
    let name = run_of(std::process::id())?;
    let domain = Domain::create(&name).map_err(|e| BenchError::Ours(e.to_string()))?;
    let mut end = RawServer::create(&domain, plan.cell.wait.policy(), plan.clients)?;
    let watched = watch()?;
    start_clients(plan, &watched)?;
    let is_over = || watched.is_stopped();
    let mut meter = Meter::new(plan.warm_up, plan.ticks, &watched.pids());
    let mut goes_on = end.gather(is_over)?;
    for tick in 0..run_ticks(plan.warm_up, plan.ticks) {
        meter.begin(tick);
        goes_on = goes_on && !is_over() && end.round(tick, is_over)?;
        if !goes_on {
            break;
        }
        watched.tick();
    }
    end.end()?;
    let bad = watched.finish();
    match bad.as_slice() {
        _ if !goes_on => Err(BenchError::Stopped),
        [] => Ok(meter.finish(String::new())),
        bad => Err(BenchError::NoResult(bad.join("; "))),
    }
}

/// A client's process.
pub fn client(plan: &ClientPlan) -> Result<(), BenchError> {
    end_with_parent(plan.cell.parent, Signal::KILL)?;
    Ok(serve_raw(&run_of(plan.cell.parent)?, plan.cell.wait.policy())?)
}
