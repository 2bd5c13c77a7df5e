//! `Sealing`: the frames of a selection as logs without truth and seed, to hand out.

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rusty_contract::blind::Told;
use rusty_contract::log::{LogError, LogWriter, TickRecord, TickRef, Trailer};
use rusty_contract::scenario::Access;
use rusty_contract::{Frame, LogHeader, OnLoss, Role, RunDigest, TruthKey};
use rusty_engine::source::{FrameSource, Simulated, SourceError, simulated_header};
use rusty_geometry::{SE2, Twist};

use super::block::run_name;
use super::entry::started;
use super::error::BenchmarkError;
use super::play::{play, side_by_side};
use super::selection::Selection;
use super::suite::{Suite, SuiteScenario};
use crate::sweep::{Seeds, SweepError};

/// Splits a log into a blind one, whose readers are told this much, and its key.
pub type Seal = fn(&Path, Told, [&Path; 2]) -> Result<(), String>;

/// What there is to seal, and where to.
pub struct Sealing<'s> {
    /// The suite.
    pub suite: &'s Suite,
    /// The part of it.
    pub selection: &'s Selection,
    /// Folder of the blind logs.
    pub blind: &'s Path,
    /// Folder of their keys.
    pub keys: &'s Path,
    /// Seals one of them.
    pub seal: Seal,
    /// Runs at a time.
    pub jobs: usize,
}

/// A run whose frames are sealed, for each map with which it is scored.
struct Run<'s> {
    scenario: &'s SuiteScenario,
    maps: Vec<Access>,
    number: u64,
    seed: u64,
}

impl Sealing<'_> {
    /// Makes each run once, without estimators, and seals it. Returns the names of the logs;
    /// `None` if `stop` was raised. `progress` is told the number of each run before it begins,
    /// and how many there are.
    ///
    /// # Errors
    /// [`BenchmarkError`] if a run cannot be made or written, or its driver is lost.
    pub fn write(
        &self,
        stop: &Arc<AtomicBool>,
        progress: impl Fn(usize, usize) + Sync,
    ) -> Result<Option<Vec<String>>, BenchmarkError> {
        let runs = self.runs()?;
        let folder = tempfile::Builder::new().prefix("rusty-benchmark-").tempdir();
        let folder = folder.map_err(BenchmarkError::io(&std::env::temp_dir()))?;
        let names = side_by_side(runs.len(), self.jobs, stop, |number| {
            progress(number, runs.len());
            let log = folder.path().join(format!("{number}.log"));
            let names = self.one(&runs[number], &log, stop)?;
            fs::remove_file(&log).map_err(BenchmarkError::io(&log))?;
            Ok(names)
        })?;
        Ok((names.len() == runs.len()).then(|| names.concat()))
    }

    /// Lists the runs. Frames of drivers depend on their commands and cannot be handed out.
    fn runs(&self) -> Result<Vec<Run<'_>>, BenchmarkError> {
        let mut runs: Vec<Run<'_>> = Vec::new();
        for (scenario, track) in self.selection.blocks(self.suite) {
            if track.is_driving() || scenario.is_recorded() {
                continue;
            }
            let is_there = |run: &&mut Run<'_>| run.scenario.name == scenario.name;
            let mut known: Vec<_> = runs.iter_mut().filter(is_there).collect();
            known.iter_mut().filter(|run| !run.maps.contains(&track.map())).for_each(|run| {
                run.maps.push(track.map());
            });
            if known.is_empty() {
                let maps = vec![track.map()];
                let seeds = (0..).zip(self.selection.seeds_of(scenario)?);
                let of = |(number, seed)| Run { scenario, maps: maps.clone(), number, seed };
                runs.extend(seeds.map(of));
            }
        }
        Ok(runs)
    }

    /// Makes a run and seals it; `None` if it was interrupted.
    fn one(
        &self,
        run: &Run<'_>,
        log: &Path,
        stop: &Arc<AtomicBool>,
    ) -> Result<Option<Vec<String>>, BenchmarkError> {
        if !write_log(run, log, stop)? {
            return Ok(None);
        }
        let name = |map: &Access| {
            let name = run_name(run.scenario, *map, run.number);
            let told = Told { initial_pose: run.scenario.start, map: *map };
            let [blind, key] = [(self.blind, "log"), (self.keys, "key")]
                .map(|(folder, ending)| folder.join(format!("{name}.{ending}")));
            let sealed = (self.seal)(log, told, [&blind, &key]);
            sealed.map_err(|problem| BenchmarkError::NotSealed { run: name.clone(), problem })?;
            Ok(name)
        };
        run.maps.iter().map(name).collect::<Result<_, BenchmarkError>>().map(Some)
    }
}

/// Writes the log of a run; `false` if it was interrupted.
fn write_log(run: &Run<'_>, log: &Path, stop: &Arc<AtomicBool>) -> Result<bool, BenchmarkError> {
    let mut roster = vec![started("score", Role::Scorer, &["score".to_owned()])];
    if !run.scenario.driver.is_empty() {
        roster.insert(0, started("driver", Role::Driver, &run.scenario.driver));
    }
    let plan = run.scenario.plan(Seeds::one(run.seed), &roster)?;
    let mut config = plan.cells[0].config.clone();
    config.seed = run.seed;
    let header = simulated_header(config, roster.clone(), OnLoss::default());
    // Replies would tell readers what the driver believes.
    let written = LogHeader { roster: Vec::new(), ..header.clone() };
    let source = Simulated::new(header).map_err(SweepError::from)?;
    let writer = LogWriter::create(log, &written)?;
    let (digest, frame) = (RunDigest::default(), Frame::boxed());
    let mut source = WritingSource { source, writer, digest, frame, ticks: 0 };
    let report = play(&roster, &mut source, stop)?;
    if report.ended == "interrupted" {
        return Ok(false);
    }
    if let Some(problem) = report.lost() {
        let run = run_name(run.scenario, run.maps[0], run.number);
        return Err(BenchmarkError::NotSealed { run, problem });
    }
    source.finish()?;
    Ok(true)
}

/// The world, whose frames go into a log.
struct WritingSource<'s> {
    source: Simulated<'s>,
    writer: LogWriter<BufWriter<File>>,
    digest: RunDigest,
    /// The frame as a reader of the log has it.
    frame: Box<Frame>,
    ticks: u64,
}

impl WritingSource<'_> {
    fn finish(self) -> Result<(), LogError> {
        let Self { writer, digest, ticks, .. } = self;
        let (run_digest, world_digest) = (digest.run(), digest.world());
        writer.finish(Trailer { ticks, run_digest, world_digest }).map(drop)
    }
}

impl FrameSource for WritingSource<'_> {
    fn header(&self) -> &LogHeader {
        self.source.header()
    }

    fn make(
        &mut self,
        driver: Option<Twist>,
        frame: &mut Frame,
    ) -> Result<Option<SE2>, SourceError> {
        let truth = self.source.make(driver, frame)?;
        let dt_s = self.header().config.dt_s;
        let record = TickRecord::from(TickRef::new(frame, truth, &[], dt_s));
        record.write_frame(&mut self.frame, dt_s, &TruthKey::from_bytes([0; 32]));
        record.absorb(&self.frame, &mut self.digest);
        self.writer.tick(TickRef::from(&record))?;
        self.ticks += 1;
        Ok(truth)
    }

    fn needs_no_answer(&self) -> bool {
        self.source.needs_no_answer()
    }

    fn prepare(&mut self) {
        self.source.prepare();
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        self.source.again()
    }
}
