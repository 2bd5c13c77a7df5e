//! The set-up of a run, from its options to its participants' processes.

use std::path::{Path, PathBuf};

use rusty_contract::output::make_folder;
use rusty_contract::{
    Brief, Credentials, Json as _, LogHeader, MAX_PARTICIPANTS, Participant, Role, RunName,
    Scenario, Start, TruthKey,
};
use rusty_link::{Domain, ServerLink, WaitPolicy, with_umask};

use super::crew::Series;
use super::limits::check_limits;
use super::program::check_programs;
use super::{Children, Crew, Pace, Run, RunError, Spawn, Stop};
use crate::confine::{self, Gate};
use crate::source::FrameSource;

/// Returns a run name that no other run has: a word and eight random digits.
///
/// # Errors
/// [`RunError`] if there is no randomness, or the word cannot be in a name.
pub fn fresh_name(word: &str) -> Result<RunName, RunError> {
    Ok(RunName::new(&format!("{word}-{:08x}", getrandom::u32()?))?)
}

/// The options of a run.
#[derive(Clone)]
pub struct RunBuilder {
    /// Name of the run.
    pub run: RunName,
    /// How the server and the participants it starts wait.
    pub wait: WaitPolicy,
    /// How fast time goes.
    pub pace: Pace,
    /// Whether it begins paused.
    pub paused: bool,
    /// Time for all to join, s.
    pub join_timeout_s: f64,
    /// Time for an answer, s.
    pub answer_timeout_s: f64,
    /// Whether all participants are started by hand.
    pub by_hand: bool,
    /// Whether the server makes the next tick, or what of it depends on no answer, while
    /// the participants work on this one. It changes no bit of the run.
    pub overlap: bool,
    /// Whether it shows no progress.
    pub quiet: bool,
    /// Whether scorers draw a report.
    pub report: bool,
    /// Signals; `None`: the run listens for them itself.
    pub stop: Option<Stop>,
    /// The robot's name, where several share a world.
    pub robot: Option<String>,
    /// The run of another robot that sets the pace and the pauses of this one.
    pub leader: Option<RunName>,
}

/// A run that has its name to itself; nothing is started yet.
pub struct PreparedRun {
    options: RunBuilder,
    gates: Vec<Gate>,
    stop: Stop,
    run_id: u64,
    key: TruthKey,
    domain: Domain,
}

impl RunBuilder {
    /// A run at full speed with the timeouts of a scenario that gives none.
    #[must_use]
    pub fn new(run: RunName, wait: WaitPolicy) -> Self {
        let Scenario { join_timeout_s, answer_timeout_s, .. } = Scenario::default();
        Self {
            run,
            wait,
            pace: Pace::Max,
            paused: false,
            join_timeout_s,
            answer_timeout_s,
            by_hand: false,
            overlap: true,
            quiet: true,
            report: true,
            stop: None,
            robot: None,
            leader: None,
        }
    }

    /// Checks programs, sandboxes and limits, listens for signals, and takes the name.
    ///
    /// # Errors
    /// [`RunError`] names what cannot be had.
    pub fn prepare(self, roster: &[Participant]) -> Result<PreparedRun, RunError> {
        if !self.by_hand {
            check_programs(roster)?;
        }
        let gates = confine::gates(roster, self.by_hand)?;
        check_limits(1, roster.len())?;
        let stop = match &self.stop {
            Some(stop) => stop.clone(),
            None => Stop::listen(std::slice::from_ref(&self.run))?,
        };
        // Traces of killed runs go first. `clean` names what cannot go now.
        let _ = Domain::sweep_dead();
        let domain = Domain::create(&self.run)?;
        let (run_id, key) = RunIdentity::draw()?;
        Ok(PreparedRun { options: self, gates, stop, run_id, key, domain })
    }

    /// Sets up the run of `source`. Participants write to `out_dir`.
    ///
    /// # Errors
    /// [`RunError`]; participants that were started are ended.
    pub fn build<'a>(
        self,
        source: &'a mut dyn FrameSource,
        out_dir: &Path,
    ) -> Result<Run<'a>, RunError> {
        self.prepare(&source.header().roster)?.build(source, out_dir)
    }
}

impl PreparedRun {
    /// The run's place on this machine.
    #[must_use]
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// The credentials of an observer that shows the truth: it has no slot.
    #[must_use]
    pub fn observer_credentials(&self) -> Credentials {
        Credentials::new(&self.key, MAX_PARTICIPANTS, true)
    }

    /// How far the kernel confines each participant, in roster order.
    #[must_use]
    pub fn gates(&self) -> &[Gate] {
        &self.gates
    }

    /// Starts everyone in the roster who has a command.
    ///
    /// # Errors
    /// [`RunError`] names the participant; those already started are ended.
    pub fn spawn(&self, roster: &[Participant], out_dir: &Path) -> Result<Children, RunError> {
        let (wait, groups) = (self.options.wait, self.stop.groups());
        let spawn = Spawn { run: &self.options.run, wait, key: &self.key, out_dir, groups };
        Ok(Children::start(roster, &self.gates, &spawn)?)
    }

    /// Opens the shared memory and starts the participants of `source`.
    ///
    /// # Errors
    /// [`RunError`]; participants that were started are ended.
    pub fn build<'a>(
        self,
        source: &'a mut dyn FrameSource,
        out_dir: &Path,
    ) -> Result<Run<'a>, RunError> {
        let crew = self.crew(&source.header().roster, out_dir)?;
        crew.begin(source, out_dir, false)
    }

    /// Opens the shared memory and starts the participants of a series of runs, which write
    /// to the folder `out_dir`. It is made if need be.
    ///
    /// # Errors
    /// [`RunError`]; participants that were started are ended.
    pub fn crew(self, roster: &[Participant], out_dir: &Path) -> Result<Crew, RunError> {
        for (slot, participant) in roster.iter().enumerate() {
            if self.options.by_hand || participant.command.is_empty() {
                let credentials = Credentials::new(&self.key, slot, participant.role.holds_key());
                self.domain.leave_credentials(&participant.name, &credentials)?;
            }
        }
        with_umask(|| make_folder(out_dir)).map_err(|error| {
            let path = out_dir.display().to_string();
            RunError::Folder { path, error }
        })?;
        // Before any participant is started: one that is killed while it makes the
        // first file of a domain leaves a name that no process can use.
        let link = ServerLink::create(&self.domain, self.options.wait, &self.key)?;
        let children = match self.options.by_hand {
            true => Children::default(),
            false => self.spawn(roster, out_dir)?,
        };
        let check_frames = self.gates.iter().any(Gate::confines);
        let series = Series::new(self.options, (self.run_id, self.key), check_frames);
        Ok(Crew { series, link, children, stop: self.stop, domain: self.domain })
    }
}

/// The secrets of a run, and what it tells its participants.
#[derive(Clone, Debug)]
pub struct RunIdentity {
    /// Drawn afresh.
    pub run_id: u64,
    /// Drawn afresh.
    pub key: TruthKey,
    /// How the server waits.
    pub wait: WaitPolicy,
    /// Where scorers and loggers write.
    pub out_dir: PathBuf,
    /// Whether participants check the bytes of every frame: where one of them is
    /// confined.
    pub check_frames: bool,
    /// Whether scorers draw a report.
    pub report: bool,
    /// Whether participants may ask for another run after this one.
    pub more_runs: bool,
    /// Number of the run in its series, from 0.
    pub run_number: u64,
}

impl RunIdentity {
    /// Returns a run id and a key from the operating system.
    ///
    /// # Errors
    /// [`RunError::Random`] if it has no randomness to give.
    pub fn draw() -> Result<(u64, TruthKey), RunError> {
        let mut key = [0; 32];
        getrandom::fill(&mut key)?;
        Ok((getrandom::u64()?, TruthKey::from_bytes(key)))
    }

    /// Returns what the participant at `slot` is told: what its role may know.
    #[must_use]
    pub fn start(&self, header: &LogHeader, slot: usize) -> Start {
        self.start_of(header, slot, &header.roster[slot])
    }

    /// Returns what an observer is told, which has no slot: nothing without the key.
    #[must_use]
    pub fn observer_start(&self, header: &LogHeader) -> Start {
        let observer = Participant { required: false, ..Participant::new("view", Role::Scorer) };
        self.start_of(header, header.roster.len(), &observer)
    }

    fn start_of(&self, header: &LogHeader, slot: usize, participant: &Participant) -> Start {
        let sealed_brief = participant.role.holds_key().then(|| {
            let out_dir = Some(self.out_dir.display().to_string());
            let brief = Brief { header: header.clone(), out_dir, report: self.report };
            // A header that came from JSON goes back to JSON.
            let json = brief.to_json().unwrap_or_default();
            self.key.seal_brief(self.run_id, &json)
        });
        Start {
            run_id: self.run_id,
            server_pid: std::process::id(),
            server_awake_ns: self.wait.awake_ns(),
            check_frames: self.check_frames,
            more_runs: self.more_runs,
            run_number: self.run_number,
            sealed_brief,
            ..Start::new(header, slot, participant)
        }
    }
}
