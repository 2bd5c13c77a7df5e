//! A server's process, over the transports of the others: starts its clients,
//! measures, ends them.

use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rusty_contract::Frame;
use signal_hook::consts::{SIGINT, SIGTERM};

use crate::cli::ServerPlan;
use crate::error::BenchError;
use crate::meter::{Measured, Meter, run_ticks};
use crate::transport::{self, ServerEnd};
use crate::watchdog::Watched;
use crate::work::{self, World};

/// One measurement.
pub fn measure(plan: &ServerPlan) -> Result<Measured, BenchError> {
    let cell = &plan.cell;
    let ticks = run_ticks(plan.warm_up, plan.ticks);
    let config = work::config(ticks, cell.scans)?;
    let mut world = World::new(config, plan.clients)?;
    let watched = watch()?;
    let mut end = transport::server(cell.contender, cell.wait, &cell.folder)?;
    start_clients(plan, &watched)?;
    end.gather(plan.clients)?;
    let mut meter = Meter::new(plan.warm_up, plan.ticks, &watched.pids());
    let mut done = 0;
    while done < ticks && !watched.is_stopped() {
        meter.begin(done);
        tick(&mut *end, &mut world)?;
        watched.tick();
        done += 1;
    }
    end.publish(&mut |frame: &mut Frame| world.end(frame))?;
    let bad = watched.finish();
    if watched.is_stopped() {
        return Err(BenchError::Stopped);
    }
    if !bad.is_empty() {
        return Err(BenchError::NoResult(bad.join("; ")));
    }
    Ok(meter.finish(world.digest()))
}

/// One tick: the frame goes out, everyone answers.
fn tick(end: &mut dyn ServerEnd, world: &mut World) -> Result<(), BenchError> {
    end.publish(&mut |frame: &mut Frame| world.write(frame))?;
    while !world.is_complete() {
        world.take(&end.next_answer()?)?;
    }
    world.close();
    Ok(())
}

/// A watchdog that learns of signals to this process.
pub fn watch() -> Result<Watched, BenchError> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop))
            .map_err(BenchError::io("signals".as_ref()))?;
    }
    Watched::new(stop).map_err(BenchError::io("a thread".as_ref()))
}

/// Starts the clients of `plan`, which are watched from then on.
pub fn start_clients(plan: &ServerPlan, watched: &Watched) -> Result<(), BenchError> {
    let program = Path::new("/proc/self/exe");
    for place in 0..plan.clients {
        let mut command = Command::new(program);
        command.arg("client").args(plan.cell.to_args()).args(["--place", &place.to_string()]);
        command.stdin(Stdio::null()).stdout(Stdio::null());
        watched.add(command.spawn().map_err(BenchError::io(program))?);
    }
    Ok(())
}
