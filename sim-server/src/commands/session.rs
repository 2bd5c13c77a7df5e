//! A run with its first line, progress, report and exit code.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow};
use rusty_contract::config::check_seconds;
use rusty_contract::score::seconds;
use rusty_contract::{
    Credentials, Exit, FieldError, LogHeader, Phase, RunName, TruthKey, errln, outln,
};
use rusty_engine::confine::{self, Gate};
use rusty_engine::lockstep::LossKind;
use rusty_engine::run::{
    Children, Leaving, Outcome, Progress, Run, RunSetup, Spawn, Stop, check_limits, find_program,
};
use rusty_engine::source::FrameSource;
use rusty_link::{Domain, ServerLink};
use rusty_logs::folder::{FreeFolder, Marker, RunEnd};

use super::arguments::RunArgs;
use super::report::{RunReport, how_ended};
use super::warn_of_guessable_seed;

/// Who starts the participants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Starting {
    /// The server.
    Launch,
    /// The user.
    ByHand,
}

/// The name of a run and the folder that is free for it.
pub(super) struct RunPlace {
    name: RunName,
    folder: FreeFolder,
}

impl RunPlace {
    /// Looks for it; nothing is written yet. `played` is a log that the run reads.
    pub(super) fn find(args: &RunArgs, scenario: &str, played: Option<&Path>) -> Result<Self> {
        let name = match &args.run {
            Some(name) => name.clone(),
            None => fresh_name(scenario)?,
        };
        let path = args.out.clone().unwrap_or_else(|| Path::new("runs").join(name.as_str()));
        Ok(Self { folder: FreeFolder::check(&path, args.force, played)?, name })
    }
}

/// A run to be made.
pub(super) struct RunSession<'a> {
    pub args: &'a RunArgs,
    pub starting: Starting,
    pub answer_timeout_s: f64,
    pub join_timeout_s: f64,
    /// Whether a first line says what is run.
    pub announced: bool,
}

/// A run that was made, before anybody is told of it.
pub(super) struct Made {
    pub header: LogHeader,
    pub name: RunName,
    pub out_dir: PathBuf,
    pub outcome: Outcome,
    /// Participants that ended badly after the run: seat and how.
    pub ended_badly: Vec<(usize, String)>,
    /// The files for what participants print, of those that the server started.
    pub outputs: Vec<(usize, PathBuf)>,
    /// How far the kernel confines each participant.
    pub gates: Vec<Gate>,
}

impl RunSession<'_> {
    pub(super) fn run(self, place: RunPlace, source: &mut dyn FrameSource) -> Result<Exit> {
        let made = self.make(place, source)?;
        let Made { header, name, out_dir, outcome, ended_badly, outputs, gates } = &made;
        let report = RunReport::new(header, name, out_dir, outcome, ended_badly, source)
            .with_outputs(header, outputs, ended_badly)
            .with_gates(header, gates);
        self.args.output.print(&report);
        Ok(report.exit())
    }

    /// Makes the run, from the first join to the end of run of the last participant.
    pub(super) fn make(&self, place: RunPlace, source: &mut dyn FrameSource) -> Result<Made> {
        let RunPlace { name, folder } = place;
        let args = self.args;
        let header = source.header().clone();
        let gates = close_gates(&header, self.starting)?;
        let (answer_timeout_s, join_timeout_s) = self.timeouts_s()?;
        check_limits(header.roster.len())?;
        let stop = listen(&name)?;
        // `clean` names what cannot be removed here.
        let _ = Domain::sweep_dead();
        let domain = Domain::create(&name)?;
        let mut folder = folder.take(Marker::new(name.as_str(), &header))?;
        let out_dir = folder.path().to_owned();
        let (run_id, key) = RunSetup::draw().context(NO_RANDOM)?;
        if self.announced {
            self.first_line(&header, &name, source.ticks());
            if header.roster.iter().any(|p| !p.sandbox.is_none()) {
                warn_of_guessable_seed(&header, "a confined participant");
            }
        }
        leave_credentials(&domain, &header, self.starting, &key)?;
        // Before anybody is started: who is confined may use what is there.
        let link = ServerLink::create(&domain, args.wait, &key)?;
        let mut children = match self.starting {
            Starting::Launch => {
                let (run, wait, out_dir) = (&name, args.wait, &*out_dir);
                let (gates, groups) = (&*gates, stop.groups());
                let spawn = Spawn { run, wait, key: &key, out_dir, gates, groups };
                Children::start(&header.roster, &spawn)?
            }
            Starting::ByHand => Children::default(),
        };
        folder.begin();
        let setup = RunSetup {
            run: name.clone(),
            run_id,
            key,
            wait: args.wait,
            pace: args.pace,
            paused: args.paused,
            dt_s: header.config.dt_s,
            join_timeout_s,
            answer_timeout_s,
            on_loss: header.on_loss,
            out_dir: Some(out_dir.clone()),
            check_frames: gates.iter().any(Gate::confines),
        };
        let progress = Progress::new(source.ticks(), args.quiet || args.output.json);
        let run = Run::new(setup, link, source, &mut children, &stop, progress);
        let outcome = run.drive()?;
        let output = |seat| Some((seat, children.output(seat)?.to_owned()));
        let outputs = (0..header.roster.len()).filter_map(output).collect();
        let ended_badly = children.finish(|seat| how_left(&outcome, seat));
        drop(domain);
        let end = RunEnd {
            ended: how_ended(outcome.phase).to_owned(),
            ticks: outcome.ticks,
            digest: outcome.digest.run_hex(),
        };
        // The run is none the worse for it; `runs` then has it as cut short.
        folder.end(end).unwrap_or_else(|e| errln!("{e}"));
        Ok(Made { header, name, out_dir, outcome, ended_badly, outputs, gates })
    }

    /// How long an answer, and joining, may take, s.
    fn timeouts_s(&self) -> Result<(f64, f64), FieldError> {
        let answer_s = self.args.answer_timeout.unwrap_or(self.answer_timeout_s);
        let join_s = self.args.join_timeout.unwrap_or(self.join_timeout_s);
        check_seconds("--answer-timeout", answer_s)?;
        check_seconds("--join-timeout", join_s)?;
        Ok((answer_s, join_s))
    }

    fn first_line(&self, header: &LogHeader, name: &RunName, ticks: u64) {
        let config = &header.config;
        let line = format!(
            "{} · scenario {} · {ticks} ticks of {} s · run {name}",
            header.seed_in_words(),
            config.scenario,
            seconds(config.dt_s)
        );
        if self.args.output.json {
            errln!("{line}");
        } else {
            outln!("{line}");
        }
        if self.args.paused {
            errln!("paused; `sim-server control {name} step` or `resume` lets it go on");
        }
        if self.starting == Starting::ByHand {
            let expected: Vec<&str> =
                header.roster.iter().filter(|p| p.is_awaited()).map(|p| p.name.as_str()).collect();
            errln!("waiting for {} (each with --run {name})", expected.join(", "));
            return;
        }
        for p in header.roster.iter().filter(|p| p.is_awaited() && p.command.is_empty()) {
            let p = &p.name;
            let found = find_program(p, p).ok().map(|path| path.display().to_string());
            let offer = found.map(|path| format!(", or use --add {p}={p} ({path})"));
            let offer = offer.unwrap_or_default();
            errln!("waiting for {p}, which has no command: start it with --run {name}{offer}");
        }
    }
}

/// Returns how a participant left the run.
fn how_left(outcome: &Outcome, seat: usize) -> Leaving {
    let summary = &outcome.seats[seat];
    match &summary.lost {
        Some(loss) if loss.kind == LossKind::Failed => Leaving::Failed,
        Some(loss) if loss.kind == LossKind::Dead => Leaving::Dead,
        None if outcome.phase == Phase::Aborted => match summary.pid {
            Some(_) => Leaving::Aborted,
            None => Leaving::TooLate,
        },
        None if summary.pid.is_some() => Leaving::AtTheEnd,
        _ => Leaving::Lost,
    }
}

/// Closes this process's memory, decides how everyone is confined, and has a
/// line for each whose sandbox is not what was wished for.
fn close_gates(header: &LogHeader, starting: Starting) -> Result<Vec<Gate>> {
    let gates = confine::gates(&header.roster, starting == Starting::ByHand)?;
    confine::close_memory().context("this process's memory")?;
    for (participant, gate) in header.roster.iter().zip(&gates) {
        if matches!(gate, Gate::Partial { .. } | Gate::Down { .. }) {
            errln!("{}: {gate}", participant.name);
        }
    }
    Ok(gates)
}

const NO_RANDOM: &str = "the operating system gives no random bytes for the run's key";

/// Returns the signals that end a run, and starts to listen for them.
pub(super) fn listen(run: &RunName) -> Result<Stop> {
    Stop::listen(run).map_err(|e| {
        anyhow!(
            "starting the thread that listens for signals failed: {e}; end other processes of \
             this user, or raise `ulimit -u`"
        )
    })
}

/// Returns the scenario's name, shortened, and eight random digits.
pub(super) fn fresh_name(scenario: &str) -> Result<RunName> {
    let random = getrandom::u32().context(NO_RANDOM)?;
    let stem: String =
        scenario.chars().filter(|c| c.is_ascii_alphanumeric() || *c == '-').take(14).collect();
    let stem = stem.trim_start_matches('-');
    let stem = if stem.is_empty() { "run" } else { stem };
    Ok(RunName::new(&format!("{stem}-{random:08x}"))?)
}

/// Leaves the credentials of everyone who is started by hand where they look
/// for them.
fn leave_credentials(
    domain: &Domain,
    header: &LogHeader,
    starting: Starting,
    key: &TruthKey,
) -> Result<()> {
    for (slot, participant) in header.roster.iter().enumerate() {
        if starting == Starting::ByHand || participant.command.is_empty() {
            let credentials = Credentials::new(key, slot, participant.role.holds_key());
            domain.leave_credentials(&participant.name, &credentials)?;
        }
    }
    Ok(())
}
