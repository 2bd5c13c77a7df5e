//! `Recordings`: replays logs of robots. Each is a run.

use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rusty_contract::{FieldError, Participant, RunName, Sandbox, Scenario};
use rusty_engine::confine;
use rusty_engine::run::{RunBuilder, Stop};
use rusty_engine::source::FrameSource;
use xxhash_rust::xxh3::Xxh3;

use super::block::Block;
use super::error::BenchmarkError;
use super::recorded_log::RecordedLog;
use super::run::BenchmarkRun;
use crate::sweep::crews::report;
use crate::sweep::inside::Place;

/// Opens a log that these participants replay.
pub type OpenLog = fn(&Path, Vec<Participant>) -> Result<Box<dyn FrameSource>, String>;

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
    /// [`BenchmarkError::Io`] if one cannot be read.
    pub fn of(paths: &[PathBuf]) -> Result<Self, BenchmarkError> {
        let log = |path: &PathBuf| {
            let name = path.file_stem().map(|n| n.to_string_lossy().into_owned());
            let digest = digest(path).map_err(BenchmarkError::io(path))?;
            Ok(RecordedLog { name: name.unwrap_or_default(), digest })
        };
        let logs = paths.iter().map(log).collect::<Result<_, BenchmarkError>>()?;
        Ok(Self { logs, paths: paths.to_vec() })
    }

    /// Returns those of a result, in its order.
    ///
    /// # Errors
    /// [`FieldError`] names the first that is not there.
    pub fn matching(&self, wanted: &[RecordedLog]) -> Result<Self, FieldError> {
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

    /// Replays each log to the entry of a block.
    pub(super) fn runs(
        &self,
        block: &Block<'_>,
        sandbox: Sandbox,
        open: OpenLog,
        stop: &Arc<AtomicBool>,
    ) -> Result<Vec<BenchmarkRun>, BenchmarkError> {
        let roster = block.entry.roster(block.scenario, block.map, sandbox);
        let mut runs = Vec::new();
        for (place, path) in self.paths.iter().enumerate() {
            if stop.load(Ordering::Relaxed) {
                break;
            }
            runs.extend(replay(block, &roster, (place as u64, path), open, stop)?);
        }
        Ok(runs)
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
    let no_log = |problem| BenchmarkError::NoLog { path: path.display().to_string(), problem };
    let mut source = open(path, roster.to_vec()).map_err(no_log)?;
    let run = |e: rusty_engine::run::RunError| BenchmarkError::Sweep(e.into());
    // Participants cannot read the truth from this process.
    confine::close_memory().map_err(BenchmarkError::io(Path::new("this process's memory")))?;
    let name = RunName::new(&format!("recording-{}-{seed}", std::process::id()))
        .map_err(|e| no_log(e.to_string()))?;
    let Scenario { join_timeout_s, answer_timeout_s, .. } = Scenario::default();
    let options = RunBuilder {
        join_timeout_s,
        answer_timeout_s,
        report: false,
        stop: Some(Stop::of(Arc::clone(stop))),
        ..RunBuilder::new(name, Default::default())
    };
    let prepared = options.prepare(roster).map_err(run)?;
    let out = prepared.domain().folder().join("out");
    fs::create_dir_all(&out).map_err(BenchmarkError::io(&out))?;
    let crew = prepared.crew(roster, &out).map_err(run)?;
    let (outcome, crew) = crew.run(source.as_mut(), &out).map_err(run)?;
    let report = report(&outcome, roster, &out);
    let config = source.header().config.clone();
    let _ = crew.finish();
    if report.ended == "interrupted" {
        return Ok(None);
    }
    let estimator = block.entry.name.clone();
    let row = report.row(Place { cell: 0, seed, estimator }, &config);
    let of = (block.scenario, block.map);
    Ok(Some(BenchmarkRun::of(&row, report.lost().as_deref(), source.tick_count(), of)))
}
