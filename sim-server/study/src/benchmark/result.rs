//! `BenchmarkResult`: the file that a benchmark writes.

use std::fmt;
use std::path::Path;

use rusty_contract::{TextTable, input, replace};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::entry::Entry;
use super::error::BenchmarkError;
use super::run::BenchmarkRun;
use super::selection::Selection;
use super::standings::{BenchmarkScore, BenchmarkVerdict, standings};
use super::suite::Suite;

/// Version of the form of this file.
const SCHEMA: u32 = 1;
/// Longest file that is read, bytes.
const MAX_FILE_BYTES: u64 = 64 << 20;

/// The result of a benchmark.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BenchmarkResult {
    /// Version of the form of this file.
    pub schema: u32,
    /// Version of the suite.
    pub suite_version: u32,
    /// Digest of the suite's text and of all configurations, 32 hexadecimal digits.
    pub suite_digest: String,
    /// The part of the suite that this result is about.
    pub selection: Selection,
    /// Whether the kernel confined the entries.
    pub confined: bool,
    /// Program and version that wrote it.
    pub writer: String,
    /// The machine that the compute times are of.
    pub machine: Value,
    /// Those who took part.
    pub entries: Vec<Entry>,
    /// Metrics over the seeds.
    pub scores: Vec<BenchmarkScore>,
    /// Comparisons with the baselines.
    pub verdicts: Vec<BenchmarkVerdict>,
    /// All runs.
    pub runs: Vec<BenchmarkRun>,
}

impl BenchmarkResult {
    /// Returns the result of these runs. Entries that take no part in the selection are left
    /// out.
    ///
    /// # Errors
    /// [`BenchmarkError`] if the suite cannot be read.
    pub fn of(
        suite: &Suite,
        selection: Selection,
        mut entries: Vec<Entry>,
        runs: Vec<BenchmarkRun>,
        (confined, writer, machine): (bool, String, Value),
    ) -> Result<Self, BenchmarkError> {
        let is_in = |e: &Entry| selection.blocks(suite).any(|(s, t)| e.takes_part(suite, s, t));
        entries.retain(is_in);
        let (scores, verdicts) = standings(suite, &selection, &entries, &runs);
        Ok(Self {
            schema: SCHEMA,
            suite_version: suite.version,
            suite_digest: suite.digest()?,
            selection,
            confined,
            writer,
            machine,
            entries,
            scores,
            verdicts,
            runs,
        })
    }

    /// Reads a result of this program's suite.
    ///
    /// # Errors
    /// [`BenchmarkError::NoResult`], or [`BenchmarkError::OtherSuite`].
    pub fn read(path: &Path, suite: &Suite) -> Result<Self, BenchmarkError> {
        let text =
            input::read_text_at_most(path, MAX_FILE_BYTES).map_err(BenchmarkError::io(path))?;
        let path = path.display().to_string();
        let result = serde_json::from_str::<Self>(&text)
            .map_err(|e| BenchmarkError::NoResult { path: path.clone(), problem: e.to_string() })?;
        let digest = suite.digest()?;
        if (result.schema, &result.suite_digest) != (SCHEMA, &digest) {
            return Err(BenchmarkError::OtherSuite {
                path,
                expected: format!("suite {} ({digest}), schema {SCHEMA}", suite.version),
                found: format!(
                    "suite {} ({}), schema {}",
                    result.suite_version, result.suite_digest, result.schema
                ),
                remedy: "use the version of sim-server that wrote it, or run it again",
            });
        }
        Ok(result)
    }

    /// Writes it, all or nothing.
    ///
    /// # Errors
    /// [`BenchmarkError`] if it cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), BenchmarkError> {
        let text = serde_json::to_string_pretty(self).map_err(BenchmarkError::Json)?;
        replace(path, (text + "\n").as_bytes()).map_err(BenchmarkError::io(path))
    }

    /// Returns the entries that count in a list of results, in which this one has `place`:
    /// baselines are those of the first.
    pub(super) fn entries_at(&self, place: usize) -> impl Iterator<Item = &Entry> {
        self.entries.iter().filter(move |entry| place == 0 || !entry.is_baseline)
    }

    /// Returns the number of runs that failed.
    #[must_use]
    pub fn failed(&self) -> usize {
        self.runs.iter().filter(|run| run.failure.is_some()).count()
    }
}

impl fmt::Display for BenchmarkResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = TextTable::new(
            "track  scenario  metric  entry  >mean  >95 % interval  >runs  >failed  >without",
        );
        for score in &self.scores {
            let metric = score.metric;
            let shown = |value: f64| metric.shown(value);
            let mean = score.mean.map_or("–".to_owned(), |m| shown(m) + metric.shown_unit());
            let interval = score.interval.map_or("–".to_owned(), |[low, high]| {
                format!("[{}, {}]{}", shown(low), shown(high), metric.shown_unit())
            });
            table.row(&[
                &score.track.word(),
                &score.scenario,
                &metric.words(),
                &score.entry,
                &mean,
                &interval,
                &score.runs,
                &score.failed,
                &score.without,
            ]);
        }
        write!(f, "{table}")?;
        let is_added = |name: &str| self.entries.iter().any(|e| e.name == name && !e.is_baseline);
        for v in self.verdicts.iter().filter(|v| v.decides && is_added(&v.entry)) {
            write!(
                f,
                "\n{}, {}, {} and {}: {}",
                v.scenario,
                v.track.word(),
                v.entry,
                v.baseline,
                v.text
            )?;
        }
        Ok(())
    }
}
