//! The conformance kit: plays a server that tests a client.
//!
//! A client is a program that takes part in runs, written in any language. The
//! kit starts it again and again, each time in a separate short run, and
//! plays the server by the book or, on purpose, not by the book: late, twice,
//! damaged, killed. The rules are in the documentation of
//! `rusty_contract` ("The protocol"); each check names its rule.
//!
//! In reading order:
//!
//! * [`catalogue`]: the checks and the rules they are about;
//! * `setting`: the little world a check is played in; `spoilt`: what is no
//!   part of it;
//! * `player`: a server, step by step; `client`: the process under test;
//! * `transcript`: what the client said; `fault`: how it came to grief;
//! * `checks`: the checks themselves;
//! * `dying`: a server that is killed; [`report`]: the table.

pub mod catalogue;
mod checks;
mod client;
mod dying;
pub mod fault;
mod player;
pub mod report;
mod setting;
mod spoilt;
mod transcript;
pub mod verdict;

pub use dying::serve_until_killed;

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use rusty_contract::{Participant, Role, RunName};
use rusty_link::WaitPolicy;
use tempfile::TempDir;

use catalogue::Check;
use fault::Halt;
use report::Finding;
use rusty_engine::run::{RunError, RunIdentity};
use transcript::Transcript;
use verdict::Verdict;

/// What a client is tested as, and how.
#[derive(Clone, Debug)]
pub struct Kit {
    /// What it takes part as.
    pub role: Role,
    /// Its name in the roster.
    pub name: String,
    /// Program and arguments; empty where another process starts it.
    pub command: Vec<String>,
    /// How everyone waits.
    pub wait: WaitPolicy,
    /// The longest wait for anything the client must do.
    pub patience: Duration,
    /// Raised when the kit is asked to stop.
    pub stop: Arc<AtomicBool>,
}

/// What all checks can look at.
pub struct Bench<'k> {
    kit: &'k Kit,
    /// Two undisturbed runs, of the same frames.
    undisturbed: [Transcript; 2],
}

/// The word for a role, read.
///
/// # Errors
/// Names the words there are.
pub fn role(word: &str) -> Result<Role, String> {
    use Role::{Driver, Estimator, Logger, Observer, Scorer};
    let all = [Estimator, Driver, Scorer, Logger, Observer];
    all.into_iter().find(|r| r.word() == word).ok_or_else(|| {
        let words = all.map(Role::word).join(", ");
        format!("{word:?} is no role; use one of: {words}")
    })
}

impl Kit {
    /// The client in the roster of a run.
    fn participant(&self) -> Participant {
        Participant { command: self.command.clone(), ..Participant::new(&self.name, self.role) }
    }

    /// A run name that no other run has.
    fn fresh_run(&self) -> Result<RunName, RunError> {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let n = COUNT.fetch_add(1, Ordering::Relaxed);
        Ok(RunName::new(&format!("conf-{}-{n}", std::process::id()))?)
    }

    /// A new run's identity, with `folder` for what scorers and loggers write.
    fn identity(&self, folder: &Path) -> Result<RunIdentity, RunError> {
        let (run_id, key) = RunIdentity::draw()?;
        let (wait, out_dir) = (self.wait, folder.to_owned());
        Ok(RunIdentity {
            run_id,
            key,
            wait,
            out_dir,
            check_frames: false,
            report: true,
            more_runs: false,
            run_number: 0,
        })
    }

    /// A folder that goes with the run it is for.
    fn folder(&self) -> Result<TempDir, RunError> {
        tempfile::Builder::new()
            .prefix("rusty-conformance-")
            .tempdir()
            .map_err(RunError::io(&std::env::temp_dir()))
    }

    /// Fails once the kit was asked to stop.
    fn go_on(&self) -> Result<(), Halt> {
        if self.stop.load(Ordering::Relaxed) { Err(Halt::Stopped) } else { Ok(()) }
    }

    /// Makes `wanted` checks, `jobs` at a time, and returns the result of each, in
    /// the same order; fewer where the kit was asked to stop.
    ///
    /// # Errors
    /// [`RunError`] if the kit itself cannot work: no shared memory, no such
    /// program.
    pub fn test(&self, wanted: &[&'static Check], jobs: usize) -> Result<Vec<Finding>, RunError> {
        let bench = match self.bench(wanted) {
            Ok(bench) => bench,
            Err(Halt::Kit(error)) => return Err(*error),
            Err(_) => return Ok(Vec::new()),
        };
        let next = AtomicUsize::new(0);
        let done = Mutex::new(Vec::new());
        std::thread::scope(|scope| {
            for _ in 0..jobs.clamp(1, wanted.len().max(1)) {
                scope.spawn(|| {
                    while let Some(check) = wanted.get(next.fetch_add(1, Ordering::Relaxed)) {
                        let made = self.make(check, &bench);
                        let failed = made.is_err();
                        let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
                        done.push((check.name, made));
                        if failed {
                            break;
                        }
                    }
                });
            }
        });
        let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
        let mut findings = Vec::new();
        for check in wanted {
            let Some(at) = done.iter().position(|(name, _)| *name == check.name) else { continue };
            match done.swap_remove(at).1 {
                Ok(verdict) => findings.push(Finding::new(check, verdict)),
                Err(Halt::Kit(error)) => return Err(*error),
                Err(_) => {}
            }
        }
        Ok(findings)
    }

    fn bench(&self, wanted: &[&Check]) -> Result<Bench<'_>, Halt> {
        let mut undisturbed = <[Transcript; 2]>::default();
        if wanted.iter().any(|check| check.looks_at_undisturbed) {
            for transcript in &mut undisturbed {
                *transcript = checks::undisturbed(self)?;
            }
        }
        Ok(Bench { kit: self, undisturbed })
    }

    fn make(&self, check: &Check, bench: &Bench<'_>) -> Result<Verdict, Halt> {
        if !check.roles.contains(&self.role) {
            return Ok(Verdict::NotApplicable(check.not_for.to_owned()));
        }
        match (check.make)(bench) {
            Err(Halt::Client(fault)) => Ok(Verdict::Fail(fault.to_string())),
            made => made,
        }
    }
}
