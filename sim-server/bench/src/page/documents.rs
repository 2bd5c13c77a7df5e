//! The reports of the benchmarks, as they printed them.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use serde::{Deserialize, Serialize};

use super::error::PageError;
use super::{BENCHES, Bench, PEERS};
use crate::report::{Report, results_hash};
use rusty_contract::Exit;

/// One report per benchmark, by name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Documents(BTreeMap<String, Report>);

impl From<BTreeMap<String, Report>> for Documents {
    fn from(reports: BTreeMap<String, Report>) -> Self {
        Self(reports)
    }
}

impl Documents {
    /// Reads a file that [`write`](Self::write) wrote.
    ///
    /// # Errors
    /// [`PageError::Io`] and [`PageError::NoDocuments`] name the file.
    pub fn read(path: &Path) -> Result<Self, PageError> {
        let text = fs::read_to_string(path).map_err(PageError::io(path))?;
        serde_json::from_str(&text)
            .map_err(|error| PageError::NoDocuments { path: path.display().to_string(), error })
    }

    /// Writes them as JSON, readable and with sorted keys.
    ///
    /// # Errors
    /// [`PageError::Io`] names the file.
    pub fn write(&self, path: &Path) -> Result<(), PageError> {
        let text = serde_json::to_string_pretty(self).map_err(std::io::Error::from);
        text.and_then(|text| fs::write(path, text + "\n")).map_err(PageError::io(path))
    }

    /// Returns the report of a benchmark.
    #[must_use]
    pub fn get(&self, bench: &str) -> Option<&Report> {
        self.0.get(bench)
    }

    /// Checks that every benchmark of this program has a report, and that no report
    /// was changed.
    ///
    /// # Errors
    /// [`PageError::Report`].
    pub fn check(&self) -> Result<(), PageError> {
        let wrong = |bench: &str, problem: &str| {
            let (bench, problem) = (bench.to_owned(), problem.to_owned());
            Err(PageError::Report { bench, problem })
        };
        if let Some(bench) = BENCHES.iter().find(|bench| self.get(bench.name).is_none()) {
            return wrong(bench.name, "is missing");
        }
        let is_changed = |report: &Report| results_hash(&report.results) != report.results_hash;
        match self.0.iter().find(|(_, report)| is_changed(report)) {
            Some((bench, _)) => wrong(bench, "was changed after it was measured"),
            None => Ok(()),
        }
    }

    /// Takes the report of `rusty-peers` from a file, as that program printed it.
    ///
    /// # Errors
    /// [`PageError::Io`] and [`PageError::Report`].
    pub fn take_peers(&mut self, path: &Path) -> Result<(), PageError> {
        let text = fs::read(path).map_err(PageError::io(path))?;
        self.put(PEERS, &text)
    }

    fn put(&mut self, bench: &'static str, json: &[u8]) -> Result<(), PageError> {
        let report = serde_json::from_slice(json).map_err(|error| PageError::Report {
            bench: bench.to_owned(),
            problem: format!("is not of this version ({error})"),
        })?;
        self.0.insert(bench.to_owned(), report);
        Ok(())
    }

    /// Runs a benchmark in a separate process and keeps its report in place of the
    /// one before. Its stderr is that of this process.
    ///
    /// # Errors
    /// [`PageError::Failed`] if its exit code is not 0, and
    /// [`PageError::Report`] if it prints something else.
    pub fn measure(&mut self, bench: &'static Bench, is_quick: bool) -> Result<(), PageError> {
        let quick = if is_quick { bench.quick } else { &[] };
        let failed =
            |how: String, not_exact| PageError::Failed { bench: bench.name, how, not_exact };
        let run = |program| {
            let mut command = Command::new(program);
            command.args(["bench", bench.name, "--json", "--accept-noise"]);
            command.args(bench.args).args(quick).stderr(Stdio::inherit()).output()
        };
        let ran = std::env::current_exe().and_then(run);
        let ran = ran.map_err(|error| failed(error.to_string(), false))?;
        if !ran.status.success() {
            let not_exact = ran.status.code() == Some(Exit::NotBitExact as i32);
            return Err(failed(ran.status.to_string(), not_exact));
        }
        self.put(bench.name, &ran.stdout)
    }
}
