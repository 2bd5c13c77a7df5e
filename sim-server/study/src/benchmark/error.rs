//! Why a benchmark cannot be made, read or compared.

use std::path::Path;

use rusty_contract::log::LogError;
use rusty_contract::{Exit, FieldError};
use thiserror::Error;

use crate::sweep::SweepError;

/// Why a benchmark cannot be made, read or compared.
#[derive(Debug, Error)]
pub enum BenchmarkError {
    /// An option cannot be used.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A run cannot be made.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// The suite of this program cannot be read.
    #[error("reading the suite of this program failed: {0}")]
    Suite(toml::de::Error),
    /// A value cannot be written as JSON.
    #[error("writing JSON failed: {0}")]
    Json(serde_json::Error),
    /// A file cannot be read or written.
    #[error("{path}: {error}")]
    Io {
        /// The file.
        path: String,
        /// What the operating system reports.
        error: std::io::Error,
    },
    /// A log cannot be written.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The frames of a run cannot be handed out.
    #[error("sealing the run {run} failed: {problem}")]
    NotSealed {
        /// Its name.
        run: String,
        /// What is wrong.
        problem: String,
    },
    /// A recording cannot be replayed.
    #[error("replaying a recording failed: {path}: {problem}; give a log of `sim-server import`")]
    NoLog {
        /// The file.
        path: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A file is not the result of a benchmark.
    #[error(
        "reading a result failed: {path}: {problem}; give a file that `sim-server benchmark run` \
         wrote"
    )]
    NoResult {
        /// The file.
        path: String,
        /// What is wrong with it.
        problem: String,
    },
    /// Scores, verdicts or runs of a file do not fit together.
    #[error("reading a result failed: {path}: {difference}; ask for the file as it was written")]
    Changed {
        /// The file.
        path: String,
        /// The first field that differs from what follows from the runs.
        difference: String,
    },
    /// A file is about another suite.
    #[error("comparing results failed: {path}: expected {expected}, got {found}; {remedy}")]
    OtherSuite {
        /// The file.
        path: String,
        /// Suite or selection that was expected.
        expected: String,
        /// That of the file.
        found: String,
        /// What helps.
        remedy: &'static str,
    },
}

impl BenchmarkError {
    /// Wraps an error about a file.
    pub fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.display().to_string();
        |error| Self::Io { path, error }
    }

    /// Returns the exit code that goes with it.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::Sweep(e) => e.exit(),
            Self::Field(_)
            | Self::NoLog { .. }
            | Self::NoResult { .. }
            | Self::OtherSuite { .. } => Exit::Usage,
            Self::Changed { .. } => Exit::NotBitExact,
            Self::Suite(_)
            | Self::Json(_)
            | Self::Io { .. }
            | Self::Log(_)
            | Self::NotSealed { .. } => Exit::Failed,
        }
    }
}
