//! Runs with clients whose processes stay: a crew of server and participants makes one run
//! after the other.
//!
//! Its rows are those of separate launches, to the bit, if each participant begins every
//! run alike. So the first run of a crew, in new processes, is repeated before its second,
//! in the same processes, and the answers of all who stay must be the same.
//! Where all must answer alike, whether they stay or not, it is repeated for want of a second too.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rusty_contract::{OnLoss, Participant, Phase, Role, RunName, ScoreReport};
use rusty_engine::confine;
use rusty_engine::run::{Crew, Outcome, RunBuilder, Stop};
use rusty_engine::scenario_file;
use rusty_engine::source::{Simulated, simulated_header};

use super::answer_digests::{AnswerDigests, DigestingSource};
use super::error::SweepError;
use super::journal::encoded;
use super::plan::Plan;
use super::record::Record;
use super::run_report::{LostClient, RunReport, failed, in_words};
use super::workers::Maker;

/// The largest log that is written to shared memory, bytes.
const MOST_LOG_BYTES: u64 = 32 << 20;

/// Numbers of the crews of this process, for their names.
static CREWS: AtomicU64 = AtomicU64::new(0);

/// One worker: a crew, and another one where the roster changes.
pub struct Crews<'p> {
    plan: &'p Plan,
    stop: &'p Arc<AtomicBool>,
    ticks_done: &'p AtomicU64,
    /// For what does not belong into shared memory.
    folder: &'p Path,
    cell: Option<Cell>,
    at_work: Option<AtWork>,
}

/// What all runs of a cell have in common but for its configuration.
struct Cell {
    index: usize,
    on_loss: OnLoss,
    rules: Rules,
}

/// What all runs of a crew have in common.
#[derive(Clone, PartialEq)]
struct Rules {
    roster: Vec<Participant>,
    join_timeout_s: f64,
    answer_timeout_s: f64,
    /// Whether the participants write to shared memory.
    in_memory: bool,
}

/// A crew.
struct AtWork {
    crew: Crew,
    rules: Rules,
    /// Where its participants write.
    out: PathBuf,
    /// Its first run, until it is repeated.
    first: Option<First>,
    /// What happened when it was repeated, for the next record.
    remarks: Vec<String>,
}

/// The first run of a crew, in new processes.
struct First {
    run: u64,
    on_loss: OnLoss,
    digests: AnswerDigests,
    record: Record,
    /// Names of the participants whose processes have stayed.
    stayed: Vec<String>,
}

impl<'p> Crews<'p> {
    pub(super) fn new(
        plan: &'p Plan,
        stop: &'p Arc<AtomicBool>,
        ticks_done: &'p AtomicU64,
        folder: &'p Path,
    ) -> Self {
        Self { plan, stop, ticks_done, folder, cell: None, at_work: None }
    }

    /// The cell of a run.
    fn cell(&mut self, run: u64) -> Result<&Cell, SweepError> {
        let (index, _) = self.plan.place(run);
        let known = self.cell.take().filter(|cell| cell.index == index);
        let cell = match known {
            Some(cell) => cell,
            None => self.load(index)?,
        };
        Ok(self.cell.insert(cell))
    }

    fn load(&self, index: usize) -> Result<Cell, SweepError> {
        let plan = self.plan;
        let parameters = plan.cells[index].parameters.iter();
        let changes: Vec<String> = parameters.map(|(k, v)| format!("{k}={v}")).collect();
        let scenario = scenario_file::load_unchecked(&plan.request.scenario, &changes)?.scenario;
        let (roster, config) = (plan.rosters[index].clone(), &plan.cells[index].config);
        let scans = config.ticks.checked_div(config.scan_every).unwrap_or_default();
        // A record has a few numbers for each participant, and the ranges of a scan.
        let log_bytes = config.ticks * (200 + 100 * roster.len() as u64)
            + scans * 8 * config.lidar.beams as u64;
        let in_memory =
            log_bytes <= MOST_LOG_BYTES || !roster.iter().any(|p| p.role == Role::Logger);
        let (join_timeout_s, answer_timeout_s) =
            (scenario.join_timeout_s, scenario.answer_timeout_s);
        let rules = Rules { roster, join_timeout_s, answer_timeout_s, in_memory };
        Ok(Cell { index, on_loss: scenario.on_loss, rules })
    }

    /// A crew whose processes have just been started.
    fn start(&self, rules: Rules) -> Result<AtWork, SweepError> {
        // Participants cannot read the truth from this process.
        confine::close_memory().map_err(SweepError::io(Path::new("this process's memory")))?;
        let number = CREWS.fetch_add(1, Ordering::Relaxed);
        let name = RunName::new(&format!("sweep-{}-{number}", std::process::id()))?;
        let out = self.folder.join(name.as_str());
        let options = RunBuilder {
            join_timeout_s: rules.join_timeout_s,
            answer_timeout_s: rules.answer_timeout_s,
            report: false,
            stop: Some(Stop::of(Arc::clone(self.stop))),
            ..RunBuilder::new(name, Default::default())
        };
        let prepared = options.prepare(&rules.roster)?;
        let out = match rules.in_memory {
            true => prepared.domain().folder().join("out"),
            false => out,
        };
        let crew = prepared.crew(&rules.roster, &out)?;
        Ok(AtWork { crew, rules, out, first: None, remarks: Vec::new() })
    }

    /// Makes a run with this crew, which is returned for the next.
    fn run(
        &self,
        at_work: AtWork,
        on_loss: OnLoss,
        run: u64,
    ) -> Result<(AtWork, RunReport, AnswerDigests), SweepError> {
        let (cell, seed) = self.plan.place(run);
        let AtWork { crew, rules, out, first, remarks } = at_work;
        clear(&out, &crew.stayed(&rules.roster));
        let mut config = self.plan.cells[cell].config.clone();
        config.seed = seed;
        let header = simulated_header(config, rules.roster.clone(), on_loss);
        // Only the first run and its repetition are compared.
        let mut source = DigestingSource::new(Simulated::new(header)?, crew.runs() < 2);
        let made = crew.run(&mut source, &out);
        let (outcome, crew) = made.map_err(|e| failed(self.plan, run, e.to_string()))?;
        let report = report(&outcome, &rules.roster, &out);
        Ok((AtWork { crew, rules, out, first, remarks }, report, source.digests()))
    }

    /// Repeats the first run of a crew in the same processes; `None` if it was stopped. Of
    /// a repetition in which a participant was lost, its name is kept.
    fn check(&self, at_work: AtWork, first: &First) -> Result<Option<AtWork>, SweepError> {
        let (mut at_work, report, digests) = self.run(at_work, first.on_loss, first.run)?;
        if self.stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        if !report.losses.is_empty() {
            let lost = report.losses.iter().map(|l| format!("{}: {}", l.name, l.detail));
            at_work.remarks.extend(lost);
            return Ok(Some(at_work));
        }
        let (seed, cell) = in_words(self.plan, first.run);
        let differ = |names: Vec<&str>, found: String| {
            let names = names.join(", ");
            Err(SweepError::CarriedOver { names, seed, cell: cell.clone(), found })
        };
        if let Some((tick, mut names)) = first.digests.first_difference(&digests) {
            // Others may answer at random: their processes are new ones in each run.
            names.retain(|name| self.plan.all_alike || first.stayed.iter().any(|s| s == name));
            if !names.is_empty() {
                return differ(names, format!("another answer at tick {tick}"));
            }
            return Ok(Some(at_work));
        }
        let record = report.record(self.plan, first.run, &at_work.out);
        at_work.remarks.extend(record.lost.clone());
        if comparable(record) != comparable(first.record.clone()) {
            let scorers = at_work.rules.roster.iter().filter(|p| p.role == Role::Scorer);
            return differ(scorers.map(|p| p.name.as_str()).collect(), "other scores".to_owned());
        }
        Ok(Some(at_work))
    }

    /// Ends the crew, if there is one. Where all must answer alike, the run of a crew that
    /// made but one is repeated here; who is lost in it has no next record to be named in.
    fn end(&mut self) -> Result<(), SweepError> {
        let Some(mut at_work) = self.at_work.take() else { return Ok(()) };
        let repeats = self.plan.all_alike && !self.stop.load(Ordering::Relaxed);
        if let Some(first) = at_work.first.take().filter(|_| repeats) {
            let Some(checked) = self.check(at_work, &first)? else { return Ok(()) };
            at_work = checked;
        }
        let AtWork { crew, rules, .. } = at_work;
        let mut bad = crew.finish().into_iter();
        bad.next().map_or(Ok(()), |(slot, how)| {
            Err(SweepError::Ended { name: rules.roster[slot].name.clone(), how })
        })
    }
}

impl Maker for Crews<'_> {
    fn make(&mut self, run: u64) -> Result<Option<Record>, SweepError> {
        let cell = self.cell(run)?;
        let (on_loss, rules) = (cell.on_loss, cell.rules.clone());
        if self.at_work.as_ref().is_some_and(|at_work| at_work.rules != rules) {
            self.end()?;
        }
        let mut at_work = match self.at_work.take() {
            Some(at_work) => at_work,
            None => self.start(rules)?,
        };
        let is_first = at_work.crew.runs() == 0;
        if let Some(first) = at_work.first.take() {
            let Some(checked) = self.check(at_work, &first)? else { return Ok(None) };
            at_work = checked;
        }
        let (mut at_work, mut report, digests) = self.run(at_work, on_loss, run)?;
        report.remarks.append(&mut at_work.remarks);
        if report.ended == "interrupted" {
            self.at_work = Some(at_work);
            return Ok(None);
        }
        self.ticks_done.fetch_add(report.ticks, Ordering::Relaxed);
        let record = report.record(self.plan, run, &at_work.out);
        let stayed = at_work.crew.stayed(&at_work.rules.roster);
        let is_whole = record.lost.is_none();
        if is_first && is_whole && (self.plan.all_alike || !stayed.is_empty()) {
            at_work.first = Some(First { run, on_loss, digests, record: record.clone(), stayed });
        }
        self.at_work = Some(at_work);
        if is_first && !is_whole {
            // There is no first run to compare with: the next one has new processes, too.
            self.end()?;
        }
        Ok(Some(record))
    }

    fn finish(&mut self) -> Result<(), SweepError> {
        self.end()
    }
}

/// Removes what earlier runs wrote, which a program that starts anew could read. Those that
/// stay keep their folders, and what they print.
fn clear(out: &Path, stayed: &[String]) {
    for entry in fs::read_dir(out).into_iter().flatten().flatten() {
        let (name, path) = (entry.file_name(), entry.path());
        let is_of = |stays: &String| name == **stays || name == *format!("{stays}.txt");
        if !stayed.iter().any(is_of) {
            let _ = fs::remove_file(&path).or_else(|_| fs::remove_dir_all(&path));
        }
    }
}

/// What of a run is looked at. Its scores are those in `out` that are of this run.
pub(crate) fn report(outcome: &Outcome, roster: &[Participant], out: &Path) -> RunReport {
    let digest = outcome.digest.run_hex();
    let scored = ScoreReport::read(&out.join("score.json"), Some(&digest)).ok();
    let mut remarks = outcome.remarks(roster);
    if scored.is_none() && outcome.ticks > 0 {
        remarks.push("there are no scores of this run".to_owned());
    }
    let ended = match outcome.phase {
        Phase::Interrupted => "interrupted",
        Phase::Aborted => "aborted",
        Phase::Tick | Phase::Done => "done",
    };
    let goals = scored.as_ref().and_then(|s| s.goals);
    let (blocked_ticks, scores) = scored.map(|s| (s.blocked_ticks, s.scores)).unwrap_or_default();
    let losses = outcome
        .losses
        .iter()
        .map(|loss| LostClient { name: loss.name.clone(), detail: loss.detail.clone() });
    RunReport {
        ticks: outcome.ticks,
        ended: ended.to_owned(),
        digest,
        scores,
        blocked_ticks,
        goals,
        losses: losses.collect(),
        remarks,
    }
}

/// A record as bytes, without the figures that depend on the machine.
fn comparable(mut record: Record) -> Vec<u8> {
    record.lost = None;
    for figures in record.rows.iter_mut().filter_map(|row| row.clients.as_mut()) {
        figures.compute_reported_p50_s = 0.0;
        figures.compute_reported_p99_s = 0.0;
        figures.compute_observed_p50_s = 0.0;
        figures.compute_observed_p99_s = 0.0;
    }
    encoded(&record)
}
