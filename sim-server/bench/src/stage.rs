//! Where every repetition takes place: a separate domain, real processes.

use std::cell::RefCell;
use std::path::PathBuf;

use rustix::process::Pid;
use rustix::thread::{CpuSet, sched_setaffinity};
use rusty_contract::config::RunConfig;
use rusty_contract::output::make_folder;
use rusty_contract::{OnLoss, Participant, Phase, Role, RunName};
use rusty_link::floor::FloorServer;
use rusty_link::raw::RawServer;
use rusty_link::{Domain, WaitPolicy};

use super::machine::cores;
use super::stamps::{Sample, Stamps};
use crate::error::BenchError;
use rusty_engine::run::{Pace, RunBuilder, RunError, Stop};
use rusty_engine::source::{Simulated, simulated_header};

/// How long clients may take to be there, and to answer, s.
const PATIENCE_S: f64 = 30.0;

/// What all repetitions share.
pub struct Stage<'a> {
    /// The name of every run; one after the other has it.
    pub run: &'a RunName,
    /// How everyone waits.
    pub wait: WaitPolicy,
    /// Rounds that count.
    pub rounds: usize,
    /// Rounds before them.
    pub warm_up: usize,
    /// Cores: the server's, then the clients' in turn. None: as the kernel likes.
    pub pin: &'a [usize],
    /// The wish to stop.
    pub stop: &'a Stop,
}

/// What is measured without a protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bare {
    /// The transport.
    Raw,
    /// The machine.
    Floor,
}

impl Bare {
    /// Its name on the command line of `bench-peer`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Floor => "floor",
        }
    }
}

/// N dead reckonings.
#[must_use]
pub fn estimators(count: usize) -> Vec<Participant> {
    let one = |i: usize| {
        let mut participant = Participant::new(&format!("estimator-{i}"), Role::Estimator);
        participant.command = vec!["dead-reckoning".to_owned()];
        participant
    };
    (0..count).map(one).collect()
}

/// An estimator, a scorer and a logger: what `launch` starts.
#[must_use]
pub fn mix() -> Vec<Participant> {
    let mut mix = estimators(1);
    mix.push(Participant::new("score", Role::Scorer));
    mix.push(Participant::new("logger", Role::Logger));
    mix
}

impl Stage<'_> {
    /// One run of `config` with the participants of `roster`: its ticks, the next made
    /// while this one is worked on if `overlap`. `None` if it was asked to stop.
    ///
    /// # Errors
    /// [`BenchError`] if it cannot be set up, or a participant was lost in it.
    pub fn ticks(
        &self,
        config: &RunConfig,
        roster: &[Participant],
        overlap: bool,
    ) -> Result<Option<Sample>, BenchError> {
        let stamps = Stamps::new(self.warm_up, self.rounds, Vec::new());
        let ticks = stamps.rounds_in_all() as u64;
        let config = RunConfig { ticks, ..config.clone() };
        let builder = RunBuilder { overlap, ..self.builder() };
        Ok(self.drive(builder, config, roster, stamps, |_| {})?.and_then(Stamps::finish))
    }

    /// One run at a pace, paused or not. `beside` runs next to it and gets the
    /// participants' processes. `None` if it was interrupted.
    ///
    /// # Errors
    /// [`BenchError`] if it cannot be set up, or a participant was lost in it.
    pub fn at_pace(
        &self,
        config: RunConfig,
        roster: &[Participant],
        (pace, paused): (Pace, bool),
        stamps: Stamps,
        beside: impl FnOnce(&[u32]) + Send,
    ) -> Result<Option<Stamps>, BenchError> {
        let builder = RunBuilder { pace, paused, ..self.builder() };
        self.drive(builder, config, roster, stamps, beside)
    }

    fn drive(
        &self,
        builder: RunBuilder,
        config: RunConfig,
        roster: &[Participant],
        stamps: Stamps,
        beside: impl FnOnce(&[u32]) + Send,
    ) -> Result<Option<Stamps>, BenchError> {
        let stamps = RefCell::new(stamps);
        let header = simulated_header(config, roster.to_vec(), OnLoss::Abort);
        let mut source = Simulated::new(header)?.before_each_tick(|_| stamps.borrow_mut().stamp());
        let prepared = builder.prepare(roster)?;
        let out_dir = out_dir(prepared.domain())?;
        let run = prepared.build(&mut source, &out_dir)?;
        let pids = run.processes();
        self.pin(&pids)?;
        stamps.borrow_mut().watch(pids.clone());
        let outcome = std::thread::scope(|scope| {
            scope.spawn(|| beside(&pids));
            run.drive()
        })?;
        drop(source);
        match outcome.phase {
            Phase::Interrupted => Ok(None),
            Phase::Done => Ok(Some(stamps.into_inner())),
            _ => {
                let lost: Vec<String> = outcome.losses.iter().map(ToString::to_string).collect();
                Err(BenchError::Nothing(lost.join("; ")))
            }
        }
    }

    fn builder(&self) -> RunBuilder {
        RunBuilder {
            join_timeout_s: PATIENCE_S,
            answer_timeout_s: PATIENCE_S,
            stop: Some(self.stop.clone()),
            ..RunBuilder::new(self.run.clone(), self.wait)
        }
    }

    /// As many rounds without a protocol. `None` if it was asked to stop.
    ///
    /// # Errors
    /// [`BenchError`] if it cannot be set up, or a process was lost in it.
    pub fn bare(&self, what: Bare, clients: usize) -> Result<Option<Sample>, BenchError> {
        let roster = peers(what, clients)?;
        let prepared = self.builder().prepare(&roster)?;
        let domain = prepared.domain();
        let mut raw = match what {
            Bare::Raw => Some(RawServer::create(domain, self.wait, clients)?),
            Bare::Floor => None,
        };
        let floor = match what {
            Bare::Raw => None,
            Bare::Floor => Some(FloorServer::create(domain, self.wait, clients)?),
        };
        let mut children = prepared.spawn(&roster, &out_dir(domain)?)?;
        let pids: Vec<u32> = children.processes().collect();
        self.pin(&pids)?;
        let mut stamps = Stamps::new(self.warm_up, self.rounds, pids);
        let total = stamps.rounds_in_all() as u64;
        let (mut gathered, mut died) = (false, None);
        for round in 0..=total {
            let is_over = || {
                died = (0..clients).find_map(|slot| children.ended(slot, 0));
                died.is_some() || self.stop.is_raised()
            };
            // Round 0 gathers; the others are numbered from 1.
            let went_on = match (&mut raw, &floor) {
                (Some(raw), _) if gathered => raw.round(round, is_over)?,
                (Some(raw), _) => raw.gather(is_over)?,
                (None, Some(floor)) if gathered => floor.round(round as u32, is_over),
                (None, Some(floor)) => floor.gather(is_over),
                (None, None) => false,
            };
            if !went_on {
                break;
            }
            gathered = true;
            stamps.stamp();
        }
        if let Some(raw) = &mut raw {
            raw.end()?;
        }
        if let Some(floor) = &floor {
            floor.end();
        }
        children.finish_all();
        match died {
            Some(how) => {
                Err(BenchError::Nothing(format!("{} without a protocol: {how}", what.word())))
            }
            None => Ok(stamps.finish()),
        }
    }

    /// Keeps this process and the clients on the given cores.
    fn pin(&self, pids: &[u32]) -> Result<(), BenchError> {
        let Some((own, others)) = self.pin.split_first() else { return Ok(()) };
        pin(None, *own)?;
        // With one core given, all are on it.
        let others = if others.is_empty() { self.pin } else { others };
        for (pid, core) in pids.iter().zip(others.iter().cycle()) {
            pin(i32::try_from(*pid).ok().and_then(Pid::from_raw), *core)?;
        }
        Ok(())
    }
}

/// Makes the folder for what participants print and write. It goes with the domain.
fn out_dir(domain: &Domain) -> Result<PathBuf, RunError> {
    let folder = domain.folder().join("out");
    make_folder(&folder).map_err(RunError::io(&folder))?;
    Ok(folder)
}

/// Clients without a protocol, by this program.
fn peers(what: Bare, clients: usize) -> Result<Vec<Participant>, RunError> {
    let program = std::env::current_exe().map_err(RunError::io("/proc/self/exe".as_ref()))?;
    let peer = |client: usize| {
        let words = ["bench-peer", what.word(), &client.to_string()].map(str::to_owned);
        let mut peer = Participant::new(&format!("peer-{client}"), Role::Estimator);
        peer.command = [program.display().to_string()].into_iter().chain(words).collect();
        peer
    };
    Ok((0..clients).map(peer).collect())
}

/// Keeps a process (none: this one) on one core.
fn pin(pid: Option<Pid>, core: usize) -> Result<(), BenchError> {
    let refused = |why: &str| {
        let cores = cores();
        BenchError::Nothing(format!(
            "no process can be kept on core {core} ({why}); cores are numbered from 0, and {cores} \
             can be used here: give others with --pin, or none"
        ))
    };
    if core >= CpuSet::MAX_CPU {
        return Err(refused("there is none"));
    }
    let mut set = CpuSet::new();
    set.set(core);
    sched_setaffinity(pid, &set).map_err(|errno| refused(&errno.to_string()))
}
