//! One run as a person sees it: first line, progress, table, paths, exit code.

use crate::output::{errln, outln};
use std::fs;
use std::io::Write as _;
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

use rusty_contract::config::check_seconds;
use rusty_contract::score::seconds;
use rusty_contract::{FieldError, LogHeader, Role, RunName, TruthKey};
use rusty_link::{Domain, ServerLink};

use super::{Verbed, print_json};
use crate::cli::RunArgs;
use crate::confine::{self, Gate};
use crate::error::VerbError;
use crate::lockstep::LossKind;
use crate::report::RunReport;
use crate::run::{Children, Leaving, Outcome, Progress, Run, RunSetup, Spawn, Stop};
use crate::source::FrameSource;

/// Who starts the participants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Starting {
    /// The server.
    Launch,
    /// Somebody else.
    ByHand,
}

/// A run to be made.
pub(super) struct RunSession<'a> {
    pub args: &'a RunArgs,
    pub starting: Starting,
    pub answer_timeout_s: f64,
    pub join_timeout_s: f64,
    /// The log that is played, if one is: it must not be written over.
    pub played: Option<&'a Path>,
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
    /// How far the kernel confines each participant.
    pub gates: Vec<Gate>,
}

impl RunSession<'_> {
    pub(super) fn run(self, source: &mut dyn FrameSource) -> Verbed {
        let made = self.make(source)?;
        let Made { header, name, out_dir, outcome, ended_badly, gates } = &made;
        let report = RunReport::new(header, name, out_dir, outcome, ended_badly, source)
            .with_gates(header, gates);
        if self.args.json {
            print_json(&report);
        } else {
            outln!("{report}");
        }
        Ok(report.exit())
    }

    /// Makes the run, from the first join to the last goodbye.
    ///
    /// # Errors
    /// [`VerbError`] before the run; losses in it are part of its outcome.
    pub(super) fn make(&self, source: &mut dyn FrameSource) -> Result<Made, VerbError> {
        let args = self.args;
        let header = source.header().clone();
        let name = match &args.run {
            Some(name) => name.clone(),
            None => fresh_name(&header.config.scenario)?,
        };
        let out_dir = args.out.clone().unwrap_or_else(|| Path::new("runs").join(name.as_str()));
        let gates = close_gates(&header, self.starting)?;
        let (answer_timeout_s, join_timeout_s) = self.timeouts_s()?;
        let stop = Stop::listen(&name).map_err(VerbError::io(Path::new("signals")))?;
        // What killed runs left behind goes first; what cannot go now hurts
        // nobody and is named by `clean`.
        let _ = Domain::sweep_dead();
        let domain = Domain::create(&name)?;
        fs::create_dir_all(&out_dir).map_err(VerbError::io(&out_dir))?;
        // Participants may run in another folder than the server.
        let out_dir = fs::canonicalize(&out_dir).map_err(VerbError::io(&out_dir))?;
        self.check_not_over_played(&header, &out_dir)?;
        remove_older_results(&header, &out_dir)?;
        let (run_id, key) = RunSetup::draw().map_err(VerbError::Random)?;
        if self.announced {
            self.first_line(&header, &name, source.ticks());
        }
        // Before anybody is started: who is confined may use what is there.
        let link = ServerLink::create(&domain, args.wait)?;
        let memory = gates.iter().any(Gate::confines).then(Domain::other_memory);
        let mut children = match self.starting {
            Starting::Launch => {
                let (run, wait, out_dir) = (&name, args.wait, &*out_dir);
                let spawn = Spawn { run, wait, key: &key, out_dir, gates: &gates };
                Children::start(&header.roster, &spawn)?
            }
            Starting::ByHand => {
                write_key(&domain, &key)?;
                Children::default()
            }
        };
        stop.covers(&children);
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
        };
        let progress = Progress::new(source.ticks(), args.quiet || args.json);
        let run = Run::new(setup, link, source, &mut children, &stop, progress);
        let outcome = run.drive()?;
        let ended_badly = children.finish(|seat| {
            let summary = &outcome.seats[seat];
            match &summary.lost {
                Some(loss) if loss.kind == LossKind::Failed => Leaving::Failed,
                None if summary.pid.is_some() => Leaving::AtTheEnd,
                _ => Leaving::Lost,
            }
        });
        drop(domain);
        name_new_memory(memory.as_deref());
        Ok(Made { header, name, out_dir, outcome, ended_badly, gates })
    }

    /// How long an answer, and joining, may take, s.
    fn timeouts_s(&self) -> Result<(f64, f64), FieldError> {
        let answer_s = self.args.answer_timeout.unwrap_or(self.answer_timeout_s);
        let join_s = self.args.join_timeout.unwrap_or(self.join_timeout_s);
        check_seconds("--answer-timeout", answer_s)?;
        check_seconds("--join-timeout", join_s)?;
        Ok((answer_s, join_s))
    }

    /// The logger of a replay truncates what it is about to write; that must not
    /// be the log that is being read.
    fn check_not_over_played(&self, header: &LogHeader, out_dir: &Path) -> Result<(), FieldError> {
        let writes = header.roster.iter().any(|p| p.role == Role::Logger);
        match self.played {
            Some(log) if writes && is_same_file(log, &out_dir.join("run.log")) => {
                let problem = "is where the log being played lies; the logger would write over it";
                let remedy = "give another folder, or --without the logger";
                Err(FieldError::new("--out", out_dir.display(), problem, remedy))
            }
            _ => Ok(()),
        }
    }

    fn first_line(&self, header: &LogHeader, name: &RunName, ticks: u64) {
        let config = &header.config;
        let line = format!(
            "{} · scenario {} · {ticks} ticks of {} s · run {name}",
            header.seed_in_words(),
            config.scenario,
            seconds(config.dt_s)
        );
        if self.args.json {
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
        }
    }
}

/// Closes this process's memory, decides how everyone is confined, and has a
/// line for each whose sandbox is not what was wished for.
fn close_gates(header: &LogHeader, starting: Starting) -> Result<Vec<Gate>, VerbError> {
    let gates = confine::gates(&header.roster, starting == Starting::ByHand)?;
    confine::close_memory().map_err(VerbError::io(Path::new("this process's memory")))?;
    for (participant, gate) in header.roster.iter().zip(&gates) {
        if matches!(gate, Gate::Partial { .. } | Gate::Down { .. }) {
            errln!("{}: {gate}", participant.name);
        }
    }
    Ok(gates)
}

/// Names the files in shared memory that a confined participant may have left;
/// `before`: the files at the start of the run, if anybody was confined.
/// They are not removed: another program of this user may have made them.
fn name_new_memory(before: Option<&[PathBuf]>) {
    let Some(before) = before else { return };
    for file in Domain::other_memory().iter().filter(|file| !before.contains(file)) {
        let file = file.display();
        errln!("{file} is new since the start of the run; unless it is in use, remove it");
    }
}

fn is_same_file(a: &Path, b: &Path) -> bool {
    match (fs::metadata(a), fs::metadata(b)) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

/// The scenario's name, shortened, and eight random digits.
fn fresh_name(scenario: &str) -> Result<RunName, VerbError> {
    let random = getrandom::u32().map_err(VerbError::Random)?;
    let stem: String =
        scenario.chars().filter(|c| c.is_ascii_alphanumeric() || *c == '-').take(14).collect();
    let stem = stem.trim_start_matches('-');
    let stem = if stem.is_empty() { "run" } else { stem };
    Ok(RunName::new(&format!("{stem}-{random:08x}"))?)
}

/// Removes what this run's scorer and logger will write: should they not come
/// to it, results of an older run must not pass for theirs.
fn remove_older_results(header: &LogHeader, out_dir: &Path) -> Result<(), VerbError> {
    let has = |role| header.roster.iter().any(|p| p.role == role);
    let log: &[&str] = if has(Role::Logger) { &["run.log"] } else { &[] };
    let scores: &[&str] = if has(Role::Scorer) {
        &["score.json", "report.html", "report.svg", "report.png"]
    } else {
        &[]
    };
    for file in log.iter().chain(scores) {
        let path = out_dir.join(file);
        // A link is somebody's wish to have it written elsewhere.
        if !fs::symlink_metadata(&path).is_ok_and(|found| found.is_file()) {
            continue;
        }
        match fs::remove_file(&path) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                return Err(VerbError::io(&path)(e));
            }
            _ => {}
        }
    }
    Ok(())
}

/// Leaves the key where scorers and loggers started by hand look for it.
fn write_key(domain: &Domain, key: &TruthKey) -> Result<(), VerbError> {
    let path: PathBuf = domain.folder().join("key");
    let file =
        fs::OpenOptions::new().write(true).create(true).truncate(true).mode(0o600).open(&path);
    file.and_then(|mut file| writeln!(file, "{}", key.to_hex())).map_err(VerbError::io(&path))
}
