//! The processes of `sim-server`, in the same program: the real lockstep, real
//! clients, the real shared memory. What `sim-server launch` does for a
//! scenario with so many estimators and without scorer and logger, with a stamp
//! where each frame is begun.

use std::path::Path;

use rustix::process::Signal;
use rusty_clients::dead_reckoning::DeadReckoning;
use rusty_clients::{ClientArgs, Session};
use rusty_contract::log::Source;
use rusty_contract::{Frame, LogHeader, OnLoss, Participant, Phase, Role, RunName};
use rusty_engine::confine;
use rusty_engine::run::{Children, Leaving, Pace, Progress, Run, RunSetup, Spawn, Stop};
use rusty_engine::source::{FrameSource, Simulated, SourceError};
use rusty_geometry::{SE2, Twist};
use rusty_link::{Domain, ServerLink};

use crate::cli::ServerPlan;
use crate::client::end_with_parent;
use crate::error::BenchError;
use crate::meter::{Measured, Meter, run_ticks};
use crate::work;

/// How long clients may take to join, and to answer, s.
const TIMEOUT_S: f64 = 30.0;

/// The world, with a stamp at the beginning of each tick.
struct Stamped {
    world: Simulated,
    meter: Meter,
    tick: u64,
}

impl FrameSource for Stamped {
    fn header(&self) -> &LogHeader {
        self.world.header()
    }

    fn ticks(&self) -> u64 {
        self.world.ticks()
    }

    fn make(
        &mut self,
        driver: Option<Twist>,
        frame: &mut Frame,
    ) -> Result<Option<SE2>, SourceError> {
        self.meter.begin(self.tick);
        self.tick += 1;
        self.world.make(driver, frame)
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        self.world.again()
    }
}

/// One measurement.
pub fn measure(plan: &ServerPlan) -> Result<Measured, BenchError> {
    let cell = &plan.cell;
    let (run_id, key) = RunSetup::draw().map_err(ours)?;
    let name = RunName::new(&format!("peers-{run_id:016x}")).map_err(ours)?;
    let stop = Stop::listen(&name).map_err(BenchError::io("signals".as_ref()))?;
    let config = work::config(run_ticks(plan.warm_up, plan.ticks), cell.scans)?;
    let roster: Vec<Participant> = (0..plan.clients).map(client).collect();
    let dt_s = config.dt_s;
    let writer = "rusty-peers".to_owned();
    let on_loss = OnLoss::Abort;
    let header = LogHeader { writer, source: Source::Simulated, config, roster, on_loss };
    let domain = Domain::create(&name).map_err(ours)?;
    let wait = cell.wait.policy();
    let link = ServerLink::create(&domain, wait, &key)?;
    let gates = confine::gates(&header.roster, false).map_err(ours)?;
    let (out_dir, groups) = (&*cell.folder, stop.groups());
    let spawn = Spawn { run: &name, wait, key: &key, out_dir, gates: &gates, groups };
    let mut children = Children::start(&header.roster, &spawn).map_err(ours)?;
    let pids: Vec<u32> = children.groups().collect();
    let setup = RunSetup {
        run: name,
        run_id,
        key,
        wait,
        pace: Pace::default(),
        paused: false,
        dt_s,
        join_timeout_s: TIMEOUT_S,
        answer_timeout_s: TIMEOUT_S,
        on_loss,
        out_dir: None,
        check_frames: false,
    };
    let meter = Meter::new(plan.warm_up, plan.ticks, &pids);
    let mut source = Stamped { world: Simulated::new(header)?, meter, tick: 0 };
    let progress = Progress::new(source.ticks(), true);
    let outcome = Run::new(setup, link, &mut source, &mut children, &stop, progress).drive()?;
    let ended_badly = children.finish(|_| Leaving::AtTheEnd);
    drop(domain);
    match (outcome.phase, ended_badly.as_slice()) {
        (Phase::Done, []) => Ok(source.meter.finish(outcome.digest.run_hex())),
        (Phase::Interrupted, _) => Err(BenchError::Stopped),
        (_, bad) => {
            let bad = bad.iter().map(|(seat, how)| format!("client {seat}: {how}"));
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
        let pose_in_world = reckoning.advance(tick.ticks());
        tick.answer(pose_in_world)?;
    }
    Ok(())
}
