//! `Recordings`: replays logs of robots. Each is a run.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rusty_contract::{FieldError, Participant, Sandbox};
use rusty_engine::source::FrameSource;
use xxhash_rust::xxh3::Xxh3;

use super::block::Block;
use super::entry::Entry;
use super::error::BenchmarkError;
use super::play::{play, side_by_side};
use super::recorded_log::RecordedLog;
use super::run::BenchmarkRun;
use crate::sweep::inside::Place;

/// Opens a log that these participants replay.
pub type OpenLog = fn(&Path, Vec<Participant>) -> Result<Box<dyn FrameSource>, String>;

/// The name of a log, by which its rows and files are called.
pub(super) fn name(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Refuses logs of one name.
pub(super) fn check_names(option: &str, paths: &[PathBuf]) -> Result<(), FieldError> {
    let is_taken = |k: &usize| paths[..*k].iter().any(|other| name(other) == name(&paths[*k]));
    (1..paths.len()).find(is_taken).map_or(Ok(()), |k| {
        let problem = "has the name of another one, and its answers are called by it";
        Err(FieldError::new(option, paths[k].display(), problem, "rename one of both"))
    })
}

/// Logs that a benchmark replays.
#[derive(Clone, Debug, Default)]
pub struct Recordings {
    /// As the result names them.
    pub logs: Vec<RecordedLog>,
    /// Where they are.
    paths: Vec<PathBuf>,
}

impl Recordings {
    /// Reads the logs once, for their digests.
    ///
    /// # Errors
    /// [`BenchmarkError::Io`] if one cannot be read; [`BenchmarkError::Field`] if two are one.
    pub fn of(paths: &[PathBuf]) -> Result<Self, BenchmarkError> {
        let log = |path: &PathBuf| {
            let digest = digest(path).map_err(BenchmarkError::io(path))?;
            Ok(RecordedLog { name: name(path), digest })
        };
        let logs = paths.iter().map(log).collect::<Result<Vec<_>, BenchmarkError>>()?;
        // Each log is a sample, and two of the same bytes are one.
        let twice =
            (1..logs.len()).find(|k| logs[..*k].iter().any(|l| l.digest == logs[*k].digest));
        if let Some(twice) = twice {
            let problem = "is given twice, or two files have the same bytes";
            let error = FieldError::new("--log", paths[twice].display(), problem, "give it once");
            return Err(error.into());
        }
        Ok(Self { logs, paths: paths.to_vec() })
    }

    /// Refuses recordings of one name where an entry has its answers by that.
    ///
    /// # Errors
    /// [`FieldError`] names the second.
    pub fn check_names(&self, entries: &[Entry]) -> Result<(), FieldError> {
        match entries.iter().any(Entry::is_by_run) {
            true => check_names("--log", &self.paths),
            false => Ok(()),
        }
    }

    /// Returns those of a result, in its order.
    ///
    /// # Errors
    /// [`FieldError`] names the first that is not there, or those of a result without any.
    pub fn matching(&self, wanted: &[RecordedLog]) -> Result<Self, FieldError> {
        if let (Some(path), true) = (self.paths.first(), wanted.is_empty()) {
            let problem = "is not replayed: the result has no recordings";
            return Err(FieldError::new("--log", path.display(), problem, "leave it out"));
        }
        let path = |log: &RecordedLog| {
            let place = self.logs.iter().position(|own| own.digest == log.digest);
            place.map(|k| self.paths[k].clone()).ok_or_else(|| {
                let RecordedLog { name, digest } = log;
                let problem = format!("has not the recording {name} of the result ({digest})");
                let given: Vec<String> =
                    self.paths.iter().map(|p| p.display().to_string()).collect();
                let remedy = "give the file from which the result was made";
                FieldError::new("--log", given.join(", "), problem, remedy)
            })
        };
        let paths = wanted.iter().map(path).collect::<Result<_, _>>()?;
        Ok(Self { logs: wanted.to_vec(), paths })
    }

    /// Replays each log to the entry of a block, `jobs` at a time.
    pub(super) fn runs(
        &self,
        block: &Block<'_>,
        (sandbox, jobs): (Sandbox, usize),
        open: OpenLog,
        stop: &Arc<AtomicBool>,
    ) -> Result<Vec<BenchmarkRun>, BenchmarkError> {
        side_by_side(self.paths.len(), jobs, stop, |number| {
            let entry = block.entry.of_run(&self.logs[number].name);
            let roster = entry.roster(block.scenario, block.map, sandbox);
            replay(block, &roster, (number as u64, &self.paths[number]), open, stop)
        })
    }
}

fn digest(path: &Path) -> io::Result<String> {
    let (mut file, mut hash, mut bytes) = (File::open(path)?, Xxh3::new(), vec![0; 1 << 16]);
    loop {
        match file.read(&mut bytes)? {
            0 => return Ok(format!("{:032x}", hash.digest128())),
            count => hash.update(&bytes[..count]),
        }
    }
}

fn replay(
    block: &Block<'_>,
    roster: &[Participant],
    (seed, path): (u64, &Path),
    open: OpenLog,
    stop: &Arc<AtomicBool>,
) -> Result<Option<BenchmarkRun>, BenchmarkError> {
    let mut source = opened(path, roster, open)?;
    let report = play(roster, source.as_mut(), stop)?;
    if report.ended == "interrupted" {
        return Ok(None);
    }
    let estimator = block.entry.name.clone();
    let row = report.row(Place { cell: 0, seed, estimator }, &source.header().config);
    let of = (block.scenario, block.map);
    Ok(Some(BenchmarkRun::of(&row, report.lost().as_deref(), source.tick_count(), of)))
}

/// Opens a log that these participants replay.
pub(super) fn opened(
    path: &Path,
    roster: &[Participant],
    open: OpenLog,
) -> Result<Box<dyn FrameSource>, BenchmarkError> {
    open(path, roster.to_vec())
        .map_err(|problem| BenchmarkError::NoLog { path: path.display().to_string(), problem })
}
