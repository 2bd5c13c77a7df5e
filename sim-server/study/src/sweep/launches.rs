//! Runs with client processes: whole lockstep runs, side by side, each by a
//! separate `sim-server launch` in a separate folder. The scorer's
//! `score.json` gives the figures, the logger's log, where there is one, the
//! way.

use std::fs::{self, File};
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};
use rusty_contract::log::{LogReader, Read};
use rusty_contract::score::{Alignment, Score};
use rusty_contract::{Effects, Exit};
use rusty_metrics::{PathLength, nees};
use serde::Deserialize;

use super::client_figures::ClientFigures;
use super::error::SweepError;
use super::inside::Place;
use super::plan::{Plan, Sampling};
use super::record::Record;
use super::track::{Sample, Track};
use super::workers::Maker;

/// Between two looks at whether a run has ended.
const BETWEEN_LOOKS: Duration = Duration::from_millis(3);

/// What of a run's report is looked at.
#[derive(Deserialize)]
struct Report {
    ticks: u64,
    ended: String,
    digest: String,
    scores: Vec<Score>,
    blocked_ticks: Option<u64>,
    losses: Vec<Loss>,
    remarks: Vec<String>,
}

#[derive(Deserialize)]
struct Loss {
    name: String,
    detail: String,
}

/// One worker: one launch after the other.
pub struct Clients<'p> {
    plan: &'p Plan,
    stop: &'p AtomicBool,
    ticks_done: &'p AtomicU64,
    /// Where the folders of the runs are.
    folder: &'p Path,
    /// Whether they stay there.
    keep: bool,
    /// Whether a folder of an earlier sweep is replaced.
    force: bool,
}

impl<'p> Clients<'p> {
    /// A worker for the runs of `plan`, with a folder for each in `folder`.
    #[must_use]
    pub fn new(
        plan: &'p Plan,
        stop: &'p AtomicBool,
        ticks_done: &'p AtomicU64,
        folder: &'p Path,
        (keep, force): (bool, bool),
    ) -> Self {
        Self { plan, stop, ticks_done, folder, keep, force }
    }

    fn command(&self, run: u64, out: &Path) -> Result<Command, SweepError> {
        let (cell, seed) = self.plan.place(run);
        let request = &self.plan.request;
        let program = std::env::current_exe().map_err(SweepError::io(Path::new("this program")))?;
        let mut command = Command::new(program);
        command.args(["launch", "--json", "--quiet", "--seed", &seed.to_string()]);
        command.arg("--run").arg(format!("sweep-{}-{run}", std::process::id()));
        command.arg("--out").arg(out);
        if self.force {
            command.arg("--force");
        }
        if !self.keep {
            command.arg("--no-report");
        }
        for (key, value) in self.plan.cells[cell].parameters.iter() {
            command.arg("--set").arg(format!("{key}={value}"));
        }
        for text in &request.add {
            command.arg("--add").arg(text);
        }
        if let Some(ticks) = request.ticks {
            command.arg("--ticks").arg(ticks.to_string());
        }
        command.arg("--").arg(&request.scenario);
        let file = |path: PathBuf| File::create(&path).map_err(SweepError::io(&path));
        let [report, said] = printed(out);
        command.stdin(Stdio::null()).stdout(file(report)?).stderr(file(said)?);
        // Ctrl-C is for the sweep, which passes it on.
        command.process_group(0);
        Ok(command)
    }

    /// Waits for the end of a run; one that is to stop is asked to, once.
    fn wait(&self, command: &mut Command) -> std::io::Result<ExitStatus> {
        let mut child = command.spawn()?;
        let mut asked = false;
        loop {
            if let Some(status) = child.try_wait()? {
                return Ok(status);
            }
            if self.stop.load(Ordering::Relaxed) && !asked {
                asked = true;
                // It is still ours: no process has waited for it.
                let _ = Pid::from_raw(child.id() as i32).map(|p| kill_process(p, Signal::INT));
            }
            std::thread::sleep(BETWEEN_LOOKS);
        }
    }

    fn record(&self, run: u64, report: &Report, out: &Path) -> Record {
        let (cell, seed) = self.plan.place(run);
        let config = &self.plan.cells[cell].config;
        let place = |name: &str| Place { cell, seed, estimator: name.to_owned() };
        let mut rows = Vec::new();
        for name in self.answering(cell) {
            let score = report.scores.iter().find(|s| s.name == name);
            let mut row =
                place(name).row(&score.map(|s| s.figures(Alignment::None)).unwrap_or_default());
            row.ticks = report.ticks;
            row.time_s = report.ticks.checked_sub(1).map_or(0.0, |tick| config.time_s(tick));
            row.distance_m = score.map_or(f64::NAN, |s| s.distance_m);
            row.blocked_ticks = report.blocked_ticks;
            row.digest.clone_from(&report.digest);
            row.clients = Some(ClientFigures::of(score));
            rows.push(row);
        }
        let sampling = self.plan.sampling(run);
        let tracks = match sampling.count() {
            0 => Vec::new(),
            _ => tracks(&out.join("run.log"), sampling, &place).unwrap_or_default(),
        };
        let losses = report.losses.iter().map(|l| format!("{}: {}", l.name, l.detail));
        let all = losses.chain(report.remarks.iter().cloned());
        // A table has one line for each run.
        let all: Vec<String> = all.map(|text| text.replace("\n    ", " | ")).collect();
        let lost = (!all.is_empty()).then(|| all.join("; "));
        Record { run, rows, tracks, lost }
    }

    /// Names of those whose answers are scored.
    fn answering(&self, cell: usize) -> impl Iterator<Item = &str> {
        let answering = self.plan.rosters[cell].iter().filter(|p| p.answers());
        answering.map(|p| p.name.as_str())
    }

    fn failed(&self, run: u64, why: String) -> SweepError {
        let (cell, seed) = self.plan.place(run);
        let parameters = self.plan.cells[cell].parameters.iter();
        let cell = parameters.map(|(k, v)| format!(", {k}={v}")).collect();
        SweepError::Launch { seed, cell, why }
    }
}

impl Maker for Clients<'_> {
    fn make(&mut self, run: u64) -> Result<Option<Record>, SweepError> {
        let (cell, seed) = self.plan.place(run);
        let out: PathBuf = self.folder.join(format!("cell-{cell}-seed-{seed}"));
        let status = self.wait(&mut self.command(run, &out)?);
        let status = status.map_err(|e| self.failed(run, e.to_string()))?;
        let [printed, said] = printed(&out);
        let text = fs::read(&printed).map_err(SweepError::io(&printed))?;
        let report = serde_json::from_slice::<Report>(&text).ok();
        let stopped = self.stop.load(Ordering::Relaxed);
        let record = match report {
            // A process that is asked to stop may have been at its last tick.
            Some(report) if report.ended != "interrupted" => {
                self.ticks_done.fetch_add(report.ticks, Ordering::Relaxed);
                let mut record = self.record(run, &report, &out);
                let fine = status.code() == Some(Exit::Done as i32);
                if !fine && record.lost.is_none() {
                    record.lost = Some(format!("the run ended with {status}"));
                }
                Some(record)
            }
            _ if stopped => None,
            _ => return Err(self.failed(run, last_lines(&said, status))),
        };
        if !self.keep {
            // What cannot be removed goes with the folder around it.
            let _ = fs::remove_dir_all(&out);
            let _ = fs::remove_file(&printed).and_then(|()| fs::remove_file(&said));
        }
        Ok(record)
    }
}

/// What a launch prints, next to its run's folder: report and talk.
fn printed(out: &Path) -> [PathBuf; 2] {
    ["json", "txt"].map(|ending| out.with_extension(ending))
}

fn last_lines(said: &Path, status: ExitStatus) -> String {
    let said = fs::read(said).unwrap_or_default();
    let said = String::from_utf8_lossy(&said);
    let line = said.lines().rev().find(|line| !line.trim().is_empty());
    line.map_or_else(|| format!("it ended with {status}"), |line| line.trim().to_owned())
}

/// The way of every estimator of a log; `None` without a log that can be read.
fn tracks(log: &Path, mut sampling: Sampling, place: &dyn Fn(&str) -> Place) -> Option<Vec<Track>> {
    let mut reader = LogReader::open(log).ok()?;
    let header = reader.header().clone();
    let mut effects = Effects::of(&header);
    let mut samples: Vec<Vec<Sample>> = header.answering().map(|_| Vec::new()).collect();
    let carried_at = header.kidnappings().map(|k| k.tick).collect();
    let (mut path, mut next) =
        (PathLength::new(header.true_start(), carried_at), sampling.next_tick());
    while let Ok(Read::Tick(entry)) = reader.read() {
        let record = entry.record;
        let has_scan = record.ranges_m.is_some();
        effects.close(record.tick, has_scan, record.replies.iter().copied());
        let truth = record.pose_in_world().filter(|p| p.is_finite());
        truth.iter().for_each(|pose| path.push(record.tick, pose));
        if record.tick != next {
            continue;
        }
        next = sampling.next_tick();
        for (samples, reply) in samples.iter_mut().zip(effects.replies()) {
            let estimate = reply.estimate().filter(|e| e.pose_in_world.is_finite());
            if let (Some(truth), Some(estimate)) = (truth, estimate) {
                let time_s = header.config.time_s(record.tick);
                let (distance_m, covariance) = (path.metres(), estimate.covariance);
                let estimate = estimate.pose_in_world;
                let nees = covariance.and_then(|c| nees(&truth, &estimate, &c));
                samples.push(Sample { time_s, distance_m, truth, estimate, nees });
            }
        }
    }
    let names = header.answering().map(|p| p.name.as_str());
    Some(names.zip(samples).map(|(name, samples)| place(name).track(samples)).collect())
}
