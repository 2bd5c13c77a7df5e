//! Where every repetition takes place: a domain of its own, real processes.

use std::fs;
use std::sync::atomic::Ordering;

use rustix::process::Pid;
use rustix::thread::{CpuSet, sched_setaffinity};
use rusty_contract::config::RunConfig;
use rusty_contract::log::Source;
use rusty_contract::{Frame, Phase, Role};
use rusty_contract::{LogHeader, OnLoss, Participant, RunName, TruthKey};
use rusty_geometry::SE2;
use rusty_geometry::Twist;
use rusty_link::floor::FloorServer;
use rusty_link::raw::RawServer;
use rusty_link::{Domain, ServerLink, WaitPolicy};

use super::machine::cores;
use super::stamps::{Sample, Stamps};
use crate::error::BenchError;
use rusty_engine::confine;
use rusty_engine::run::{Children, Leaving, Pace, Progress, Run, RunSetup, Spawn, Stop};
use rusty_engine::source::{FrameSource, Simulated, SourceError};

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

/// So many dead reckonings.
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
    /// One run of `config` with the participants of `roster`: its ticks.
    /// `None` if somebody wanted it to stop.
    ///
    /// # Errors
    /// [`BenchError`] if it cannot be set up, or somebody was lost in it.
    pub fn ticks(
        &self,
        config: &RunConfig,
        roster: &[Participant],
    ) -> Result<Option<Sample>, BenchError> {
        let stamps = Stamps::new(self.warm_up, self.rounds, Vec::new());
        let ticks = stamps.rounds_in_all() as u64;
        let config = RunConfig { ticks, ..config.clone() };
        Ok(self.drive(config, roster, (Pace::Max, false), stamps, |_| {})?.and_then(Stamps::finish))
    }

    /// One run, at a pace, paused or not, with somebody `beside` it who is told
    /// the participants' processes once all are started. `None` if it was
    /// interrupted.
    ///
    /// # Errors
    /// [`BenchError`] if it cannot be set up, or somebody was lost in it.
    pub fn drive(
        &self,
        config: RunConfig,
        roster: &[Participant],
        (pace, paused): (Pace, bool),
        mut stamps: Stamps,
        beside: impl FnOnce(&[u32]) + Send,
    ) -> Result<Option<Stamps>, BenchError> {
        let (domain, key) = self.domain()?;
        let link = ServerLink::create(&domain, self.wait, &key)?;
        let mut children = self.start(&domain, &key, roster)?;
        let pids: Vec<u32> = children.groups().collect();
        stamps.watch(pids.clone());
        let (run_id, _) = RunSetup::draw().map_err(BenchError::Random)?;
        let setup = RunSetup {
            run: self.run.clone(),
            run_id,
            key,
            wait: self.wait,
            pace,
            paused,
            dt_s: config.dt_s,
            join_timeout_s: PATIENCE_S,
            answer_timeout_s: PATIENCE_S,
            on_loss: OnLoss::Abort,
            out_dir: Some(domain.folder().join("out")),
            check_frames: false,
        };
        let header = LogHeader {
            writer: concat!("sim-server ", env!("CARGO_PKG_VERSION")).to_owned(),
            source: Source::Simulated,
            config,
            roster: roster.to_vec(),
            on_loss: OnLoss::Abort,
        };
        let mut timed = Timed { inner: Simulated::new(header)?, stamps };
        let progress = Progress::new(timed.ticks(), true);
        let run = Run::new(setup, link, &mut timed, &mut children, self.stop, progress);
        let outcome = std::thread::scope(|scope| {
            scope.spawn(|| beside(&pids));
            run.drive()
        })?;
        children.finish(|_| Leaving::AtTheEnd);
        match outcome.phase {
            Phase::Interrupted => Ok(None),
            Phase::Done => Ok(Some(timed.stamps)),
            _ => {
                let lost: Vec<String> = outcome.losses.iter().map(ToString::to_string).collect();
                Err(BenchError::Nothing(lost.join("; ")))
            }
        }
    }

    /// As many rounds without a protocol. `None` if somebody wanted it to stop.
    ///
    /// # Errors
    /// [`BenchError`] if it cannot be set up, or a process was lost in it.
    pub fn bare(&self, what: Bare, clients: usize) -> Result<Option<Sample>, BenchError> {
        let (domain, key) = self.domain()?;
        let mut raw = match what {
            Bare::Raw => Some(RawServer::create(&domain, self.wait, clients)?),
            Bare::Floor => None,
        };
        let floor = match what {
            Bare::Raw => None,
            Bare::Floor => Some(FloorServer::create(&domain, self.wait, clients)?),
        };
        let program = std::env::current_exe().map_err(BenchError::io("/proc/self/exe".as_ref()))?;
        let roster: Vec<Participant> = (0..clients)
            .map(|client| {
                let words = ["bench-peer", what.word(), &client.to_string()].map(str::to_owned);
                let mut peer = Participant::new(&format!("peer-{client}"), Role::Estimator);
                peer.command = [program.display().to_string()].into_iter().chain(words).collect();
                peer
            })
            .collect();
        let mut children = self.start(&domain, &key, &roster)?;
        let mut stamps = Stamps::new(self.warm_up, self.rounds, children.groups().collect());
        let total = stamps.rounds_in_all() as u64;
        let (mut gathered, mut died) = (false, None);
        for round in 0..=total {
            let is_over = || {
                died = (0..clients).find_map(|seat| children.ended(seat, 0));
                died.is_some() || self.stop.flag().load(Ordering::Relaxed)
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
        children.finish(|_| Leaving::AtTheEnd);
        match died {
            Some(how) => {
                Err(BenchError::Nothing(format!("{} without a protocol: {how}", what.word())))
            }
            None => Ok(stamps.finish()),
        }
    }

    /// A domain with a folder for what participants print and write. It goes
    /// with the domain.
    ///
    /// # Errors
    /// [`BenchError`] names what could not be made.
    pub fn domain(&self) -> Result<(Domain, TruthKey), BenchError> {
        let domain = Domain::create(self.run)?;
        let folder = domain.folder().join("out");
        fs::create_dir_all(&folder).map_err(BenchError::io(&folder))?;
        let (_, key) = RunSetup::draw().map_err(BenchError::Random)?;
        Ok((domain, key))
    }

    /// Whether somebody wants it to stop.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.stop.flag().load(Ordering::Relaxed)
    }

    fn start(
        &self,
        domain: &Domain,
        key: &TruthKey,
        roster: &[Participant],
    ) -> Result<Children, BenchError> {
        let gates = confine::gates(roster, false)?;
        let out_dir = domain.folder().join("out");
        let (run, wait) = (self.run, self.wait);
        let (gates, groups) = (&*gates, self.stop.groups());
        let spawn = Spawn { run, wait, key, out_dir: &out_dir, gates, groups };
        let children = Children::start(roster, &spawn)?;
        if let Some((own, others)) = self.pin.split_first() {
            pin(None, *own)?;
            // With one core given, all are on it.
            let others = if others.is_empty() { self.pin } else { others };
            for (pid, core) in children.groups().zip(others.iter().cycle()) {
                pin(i32::try_from(pid).ok().and_then(Pid::from_raw), *core)?;
            }
        }
        Ok(children)
    }
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

/// A simulation that stamps the beginning of every tick.
struct Timed {
    inner: Simulated,
    stamps: Stamps,
}

impl FrameSource for Timed {
    fn header(&self) -> &LogHeader {
        self.inner.header()
    }

    fn ticks(&self) -> u64 {
        self.inner.ticks()
    }

    fn make(
        &mut self,
        driver: Option<Twist>,
        frame: &mut Frame,
    ) -> Result<Option<SE2>, SourceError> {
        self.stamps.stamp();
        self.inner.make(driver, frame)
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        self.inner.again()
    }
}
