//! Runs with clients whose folders are kept: each by a separate `sim-server launch` in a
//! separate folder, with report and pictures.

use std::fs::{self, File};
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};
use rusty_contract::Exit;

use super::error::SweepError;
use super::plan::Plan;
use super::record::Record;
use super::run_report::{RunReport, failed};
use super::workers::Maker;

/// Between two looks at whether a run has ended.
const BETWEEN_LOOKS: Duration = Duration::from_millis(3);

/// One worker: one launch after the other.
pub struct Launches<'p> {
    plan: &'p Plan,
    stop: &'p AtomicBool,
    ticks_done: &'p AtomicU64,
    /// Where the folders of the runs are.
    folder: &'p Path,
    /// Whether a folder of an earlier sweep is replaced.
    force: bool,
}

impl<'p> Launches<'p> {
    /// A worker for the runs of `plan`, with a folder for each in `folder`.
    pub(super) fn new(
        plan: &'p Plan,
        stop: &'p AtomicBool,
        ticks_done: &'p AtomicU64,
        folder: &'p Path,
        force: bool,
    ) -> Self {
        Self { plan, stop, ticks_done, folder, force }
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
}

impl Maker for Launches<'_> {
    fn make(&mut self, run: u64) -> Result<Option<Record>, SweepError> {
        let (cell, seed) = self.plan.place(run);
        let out: PathBuf = self.folder.join(format!("cell-{cell}-seed-{seed}"));
        let status = self.wait(&mut self.command(run, &out)?);
        let status = status.map_err(|e| failed(self.plan, run, e.to_string()))?;
        let [printed, said] = printed(&out);
        let text = fs::read(&printed).map_err(SweepError::io(&printed))?;
        let report = serde_json::from_slice::<RunReport>(&text).ok();
        let stopped = self.stop.load(Ordering::Relaxed);
        let record = match report {
            // A process that is asked to stop may have been at its last tick.
            Some(report) if report.ended != "interrupted" => {
                self.ticks_done.fetch_add(report.ticks, Ordering::Relaxed);
                let mut record = report.record(self.plan, run, &out);
                let fine = status.code() == Some(Exit::Done as i32);
                if !fine && record.lost.is_none() {
                    record.lost = Some(format!("the run ended with {status}"));
                }
                Some(record)
            }
            _ if stopped => None,
            _ => return Err(failed(self.plan, run, last_lines(&said, status))),
        };
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
