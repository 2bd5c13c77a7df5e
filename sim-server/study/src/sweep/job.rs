//! A sweep from its plan to its table.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use tempfile::TempDir;

use super::cell::Swept;
use super::clients::Clients;
use super::error::SweepError;
use super::inside::Inside;
use super::journal::{Journal, lock};
use super::plan::Plan;
use super::record::Record;
use super::report::{draw, results};
use super::settings::Settings;
use super::table::Table;
use super::workers::{Listener, work};
use rusty_contract::output::make_folder;
use rusty_engine::run::{Progress, RunError, check_limits, check_programs};

/// The file of what an interrupted sweep with this table has done: `FILE.part`.
#[must_use]
pub fn journal_of(table: &Table) -> PathBuf {
    table.beside(".part")
}

/// How a sweep is carried out. None of it reaches the rows.
pub struct SweepJob {
    /// What there is to do.
    pub plan: Plan,
    /// Who writes, for the settings.
    pub writer: String,
    /// Runs at a time.
    pub jobs: usize,
    /// Where the rows go.
    pub table: Option<Table>,
    /// Whether to go on with what an interrupted sweep left.
    pub resume: bool,
    /// Whether to replace what is there.
    pub force: bool,
    /// Where the runs' folders are kept; runs with clients only.
    pub runs_dir: Option<PathBuf>,
}

/// What a sweep came to.
pub struct SweepOutcome {
    /// Rows and tracks; all of the shard's, if it is complete.
    pub swept: Swept,
    /// Runs whose rows are there.
    pub runs: u64,
    /// Runs there were to be.
    pub planned: u64,
    /// Runs that had been done before.
    pub resumed: u64,
    /// Runs in which something was lost: seed and what.
    pub lost: Vec<(u64, String)>,
    /// Ticks that were simulated now, and how long that took, s.
    pub ticks: u64,
    /// From the first run to the last, s.
    pub elapsed_s: f64,
    /// The drawings of the table.
    pub pictures: Vec<PathBuf>,
    /// The table was there already, and nothing was done.
    pub was_complete: bool,
    /// The journal that holds what is done of an interrupted sweep.
    pub journal: Option<PathBuf>,
}

impl SweepJob {
    /// Makes the runs, or those that are missing, writes the table and draws it. `stop`
    /// ends it early and keeps what is done.
    ///
    /// # Errors
    /// [`SweepError`]; what is done is in the journal.
    pub fn run(
        self,
        stop: &Arc<AtomicBool>,
        progress: Progress,
    ) -> Result<SweepOutcome, SweepError> {
        let settings = Settings::of(&self.plan, &self.writer)?;
        let (mut journal, records) = match &self.table {
            None => (None, Vec::new()),
            Some(table) => {
                if let Some(there) = self.complete(table, &settings)? {
                    return Ok(self.complete_before(there.lost()));
                }
                self.plan.rosters.iter().try_for_each(|roster| check_programs(roster))?;
                let path = journal_of(table);
                let (journal, records) =
                    Journal::open(&path, &settings, &self.plan.runs, self.force)?;
                (Some(journal), records)
            }
        };
        let made = match self.records(journal.as_mut(), records, stop, progress) {
            Ok(made) => made,
            Err(error) => {
                // Without a record there is nothing to go on with.
                let _ = journal.filter(Journal::is_empty).map(Journal::remove);
                return Err(error);
            }
        };
        let (runs, planned) = (made.records.len() as u64, self.plan.count());
        let (swept, lost) = swept(&self.plan, made.records);
        let mut came = SweepOutcome {
            swept,
            runs,
            planned,
            resumed: made.resumed,
            lost,
            ticks: made.ticks,
            elapsed_s: made.elapsed_s,
            pictures: Vec::new(),
            was_complete: false,
            journal: None,
        };
        if runs < planned {
            came.journal = journal.map(|j| j.path().to_owned());
            return Ok(came);
        }
        if let (Some(table), Some(journal)) = (&self.table, journal) {
            let settings = settings.with_lost(&came.lost);
            table.write(&came.swept, &self.plan.request.axes, &settings)?;
            // What cannot be drawn now is in the journal.
            came.pictures = draw(&came.swept, table.path())?;
            journal.remove()?;
        }
        Ok(came)
    }

    /// Makes the runs that have no record among `records` yet. Returns the records of
    /// all that are done, in order.
    ///
    /// # Errors
    /// [`SweepError`]; what is done is in the journal, if there is one.
    pub fn records(
        &self,
        journal: Option<&mut Journal>,
        mut records: Vec<Record>,
        stop: &Arc<AtomicBool>,
        progress: Progress,
    ) -> Result<Made, SweepError> {
        // A run has one record: a journal does not grow by what is in it.
        records.sort_by_key(|r| r.run);
        records.dedup_by_key(|r| r.run);
        let resumed = records.len() as u64;
        let done: BTreeSet<u64> = records.iter().map(|r| r.run).collect();
        let todo: Vec<u64> = self.plan.runs.clone().filter(|run| !done.contains(run)).collect();
        let before: u64 = done.iter().map(|run| self.plan.ticks(*run)).sum();
        let began = Instant::now();
        let ticks_done = &AtomicU64::new(0);
        let mut keeping = Keeping { journal, records, progress, before, ticks_done };
        keeping.progress.goes_on_at(before);
        let made = self.make(&todo, stop, ticks_done, &mut keeping);
        keeping.progress.done();
        let mut records = keeping.records;
        made?;
        records.sort_by_key(|r| r.run);
        let (ticks, elapsed_s) = (ticks_done.load(Ordering::Relaxed), began.elapsed());
        Ok(Made { records, resumed, ticks, elapsed_s: elapsed_s.as_secs_f64() })
    }

    /// The settings of the table that is there already, where it is this one and complete.
    /// Without leave, what is there is not touched.
    fn complete(&self, table: &Table, settings: &Settings) -> Result<Option<Settings>, SweepError> {
        let part = journal_of(table);
        if table.path().is_dir() {
            return Err(SweepError::InTheWay {
                path: table.path().display().to_string(),
                what: "is a folder".to_owned(),
                remedy: "choose another --out",
            });
        }
        if self.force {
            return Ok(None);
        }
        if !self.resume {
            if let Ok(file) = fs::File::open(&part) {
                lock(&file, &part)?;
                return Err(SweepError::InTheWay {
                    path: part.display().to_string(),
                    what: "has what an interrupted sweep had done".to_owned(),
                    remedy: "go on with --resume, or begin anew with --force",
                });
            }
            let mut files = results(table);
            if let Some(file) = files.find(|file| file.is_file()) {
                return Err(SweepError::InTheWay {
                    path: file.display().to_string(),
                    what: "is there already".to_owned(),
                    remedy: "choose another --out, or replace it with --force",
                });
            }
            return Ok(None);
        }
        // What is next to a table while it is written decides.
        if part.exists() {
            return Ok(None);
        }
        let Some(there) = table.settings()? else { return Ok(None) };
        let path = table.path().display().to_string();
        if let Some(difference) = there.difference(settings) {
            return Err(SweepError::Other { path, difference });
        }
        let rows = table.rows()?.try_fold(0, |count, row| row.map(|_| count + 1))?;
        if rows != self.plan.rows() {
            let problem = format!("has {rows} of {} rows", self.plan.rows());
            return Err(SweepError::NoSweep { path, problem });
        }
        Ok(Some(there))
    }

    fn complete_before(self, lost: Vec<(u64, String)>) -> SweepOutcome {
        let planned = self.plan.count();
        let (swept, _) = swept(&self.plan, Vec::new());
        SweepOutcome {
            swept,
            runs: planned,
            planned,
            resumed: planned,
            lost,
            ticks: 0,
            elapsed_s: 0.0,
            pictures: Vec::new(),
            was_complete: true,
            journal: None,
        }
    }

    /// Makes the runs `todo`, and counts their ticks.
    pub(super) fn make(
        &self,
        todo: &[u64],
        stop: &Arc<AtomicBool>,
        ticks_done: &AtomicU64,
        listener: &mut impl Listener,
    ) -> Result<(), SweepError> {
        if !self.plan.request.clients {
            let maker = || Inside::new(&self.plan, stop, ticks_done);
            return work(todo, self.jobs, stop, maker, listener);
        }
        let most = self.plan.rosters.iter().map(Vec::len).max().unwrap_or_default();
        check_limits(self.jobs, self.jobs * most).map_err(RunError::from)?;
        let mut own: Option<TempDir> = None;
        let folder = match &self.runs_dir {
            Some(folder) => folder.clone(),
            None => {
                let made = tempfile::Builder::new().prefix("rusty-sweep-").tempdir();
                let made = made.map_err(SweepError::io(&std::env::temp_dir()))?;
                own.insert(made).path().to_owned()
            }
        };
        make_folder(&folder).map_err(SweepError::io(&folder))?;
        let how = (own.is_none(), self.force || self.resume);
        let maker = || Clients::new(&self.plan, stop, ticks_done, &folder, how);
        work(todo, self.jobs, stop, maker, listener)
    }
}

/// The runs that are done.
pub struct Made {
    /// Their records, in order.
    pub records: Vec<Record>,
    /// The number of records that were there before.
    pub resumed: u64,
    /// Ticks that were simulated now.
    pub ticks: u64,
    /// Time from the first run to the last, s.
    pub elapsed_s: f64,
}

/// What is done goes into the journal and into memory.
struct Keeping<'s> {
    journal: Option<&'s mut Journal>,
    records: Vec<Record>,
    progress: Progress,
    /// Ticks of the runs that had a record already.
    before: u64,
    ticks_done: &'s AtomicU64,
}

impl Listener for Keeping<'_> {
    fn done(&mut self, record: Record, bytes: &[u8]) -> Result<(), SweepError> {
        if let Some(lost) = &record.lost {
            let seed = record.rows.first().map_or(0, |row| row.seed);
            self.progress.say(&format!("seed {seed}: {lost}"));
        }
        self.records.push(record);
        self.journal.as_mut().map_or(Ok(()), |journal| journal.append(bytes))
    }

    fn pause(&mut self) -> Result<(), SweepError> {
        self.progress.at(self.before + self.ticks_done.load(Ordering::Relaxed));
        self.journal.as_mut().map_or(Ok(()), |journal| journal.flush())
    }
}

/// Returns records in order as rows and tracks, and what was lost.
pub(super) fn swept(plan: &Plan, records: Vec<Record>) -> (Swept, Vec<(u64, String)>) {
    let cells = plan.cells.clone();
    let mut swept = Swept { cells, rows: Vec::new(), tracks: Vec::new() };
    let mut all_lost = Vec::new();
    for record in records {
        let (cell, seed) = plan.place(record.run);
        all_lost.extend(record.lost.map(|lost| (seed, lost)));
        swept.rows.extend(record.rows.into_iter().map(|mut row| {
            row.parameters = swept.cells[cell].parameters.clone();
            row
        }));
        swept.tracks.extend(record.tracks);
    }
    (swept, all_lost)
}
