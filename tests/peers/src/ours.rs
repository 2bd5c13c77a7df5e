//! The processes of `sim-server`, in the same program: the real lockstep, real
//! clients, the real shared memory. What `sim-server launch` does for a
//! scenario with N estimators and without scorer and logger, with a stamp
//! where each frame is begun.

use std::cell::RefCell;
use std::path::Path;

use rustix::process::Signal;
use rusty_clients::dead_reckoning::DeadReckoning;
use rusty_clients::{ClientArgs, Session};
use rusty_contract::{OnLoss, Participant, Phase, Role};
use rusty_engine::run::{RunBuilder, fresh_name};
use rusty_engine::source::{Simulated, simulated_header};

use crate::cli::ServerPlan;
use crate::client::end_with_parent;
use crate::error::BenchError;
use crate::meter::{Measured, Meter, run_ticks};
use crate::work;

/// How long clients may take to join, and to answer, s.
const TIMEOUT_S: f64 = 30.0;

/// One measurement.
pub fn measure(plan: &ServerPlan) -> Result<Measured, BenchError> {
    let cell = &plan.cell;
    let config = work::config(run_ticks(plan.warm_up, plan.ticks), cell.scans)?;
    let roster: Vec<Participant> = (0..plan.clients).map(client).collect();
    let meter = RefCell::new(None);
    let begin = |tick| {
        if let Some(meter) = meter.borrow_mut().as_mut() {
            Meter::begin(meter, tick);
        }
    };
    let mut source =
        Simulated::new(simulated_header(config, roster, OnLoss::Abort))?.before_each_tick(begin);
    let options = RunBuilder {
        join_timeout_s: TIMEOUT_S,
        answer_timeout_s: TIMEOUT_S,
        ..RunBuilder::new(fresh_name("peers").map_err(ours)?, cell.wait.policy())
    };
    let run = options.build(&mut source, &cell.folder).map_err(ours)?;
    meter.replace(Some(Meter::new(plan.warm_up, plan.ticks, &run.processes())));
    let outcome = run.drive()?;
    drop(source);
    let meter = meter.into_inner();
    match (outcome.phase, outcome.ended_badly.as_slice()) {
        (Phase::Done, []) => {
            let meter = meter.ok_or(BenchError::Stopped)?;
            Ok(meter.finish(outcome.digest.run_hex()))
        }
        (Phase::Interrupted, _) => Err(BenchError::Stopped),
        (_, bad) => {
            let bad = bad.iter().map(|(slot, how)| format!("client {slot}: {how}"));
            let lost = outcome.losses.iter().map(ToString::to_string);
            Err(ours(lost.chain(bad).collect::<Vec<_>>().join("; ")))
        }
    }
}

fn ours(problem: impl std::fmt::Display) -> BenchError {
    BenchError::Ours(problem.to_string())
}

/// Dead reckoning, by this program.
fn client(place: usize) -> Participant {
    let mut participant = Participant::new(&format!("client-{place}"), Role::Estimator);
    let program = std::env::current_exe().unwrap_or_else(|_| Path::new("/proc/self/exe").into());
    participant.command = vec![program.display().to_string(), "dead-reckoning".to_owned()];
    participant
}

/// A client's process: what the client `dead-reckoning` does.
pub fn dead_reckoning(args: &ClientArgs) -> Result<(), BenchError> {
    if let Some(launcher) = args.launcher {
        end_with_parent(launcher, Signal::KILL)?;
    }
    let mut session = Session::join(args)?;
    let start = session.start();
    let mut reckoning = DeadReckoning::of_start(start);
    while let Some(tick) = session.next()? {
        let pose_in_world = reckoning.advance(tick.encoders());
        tick.answer(pose_in_world)?;
    }
    Ok(())
}
