//! The documents of the benches, as they printed them.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::benches::{Bench, Source};
use super::error::PageError;
use crate::machine::Machine;
use rusty_contract::Exit;

/// One document per bench, by name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Documents(BTreeMap<String, Document>);

/// What a bench printed with `--json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Document {
    /// The command that printed it.
    pub command: String,
    /// On what it was measured.
    pub machine: Machine,
    /// How much that was disturbed.
    pub noise: Noise,
    /// What the bench found, in a form of its own.
    pub results: Value,
    /// XXH3-64 of the results.
    pub results_hash: String,
}

/// What the page says of a [`Noise`](crate::noise::Noise).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Noise {
    /// `quiet`, `noisy` or `not-to-be-believed`.
    pub verdict: String,
    /// Why it is not quiet.
    pub reasons: Vec<String>,
}

impl Noise {
    /// Whether nothing disturbed the machine.
    #[must_use]
    pub fn is_quiet(&self) -> bool {
        self.verdict == "quiet"
    }
}

impl Documents {
    /// Those in a file that [`write`](Self::write) wrote.
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

    /// The document of a bench; `None` where one may be absent and is.
    ///
    /// # Errors
    /// [`PageError::Missing`].
    pub fn of(&self, bench: &'static Bench) -> Result<Option<&Document>, PageError> {
        match (self.0.get(bench.name), bench.source) {
            (None, Source::Run { .. }) => Err(PageError::Missing { bench: bench.name }),
            (found, _) => Ok(found),
        }
    }

    /// Takes the document of `bench` from a file, as that program printed it.
    ///
    /// # Errors
    /// [`PageError::Io`] and [`PageError::OldDocument`].
    pub fn take(&mut self, bench: &'static Bench, path: &Path) -> Result<(), PageError> {
        let text = fs::read_to_string(path).map_err(PageError::io(path))?;
        let document = serde_json::from_str(&text)
            .map_err(|error| PageError::OldDocument { bench: bench.name, error })?;
        self.0.insert(bench.name.to_owned(), document);
        Ok(())
    }

    /// Runs a bench in a process of its own and keeps its document in place of
    /// the one before. It talks to this process's stderr. Where the document
    /// comes from a file, nothing happens.
    ///
    /// # Errors
    /// [`PageError::Failed`] if it ends with another exit code than 0, and
    /// [`PageError::OldDocument`] if it prints something else.
    pub fn measure(&mut self, bench: &'static Bench, is_quick: bool) -> Result<(), PageError> {
        let Source::Run { args, quick } = bench.source else { return Ok(()) };
        let mut command = vec!["bench", bench.name, "--json", "--accept-noise"];
        command.extend(args);
        if is_quick {
            command.extend(quick);
        }
        let failed =
            |how: String, not_exact| PageError::Failed { bench: bench.name, how, not_exact };
        let program = std::env::current_exe();
        let ran = program
            .and_then(|program| {
                Command::new(program).args(command).stderr(Stdio::inherit()).output()
            })
            .map_err(|error| failed(error.to_string(), false))?;
        if !ran.status.success() {
            let not_exact = ran.status.code() == Some(Exit::NotBitExact as i32);
            return Err(failed(ran.status.to_string(), not_exact));
        }
        let document = serde_json::from_slice(&ran.stdout)
            .map_err(|error| PageError::OldDocument { bench: bench.name, error })?;
        self.0.insert(bench.name.to_owned(), document);
        Ok(())
    }
}
