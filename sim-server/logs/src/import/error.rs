//! Why a recording cannot be imported: place, value and remedy.

use std::fmt::Display;
use std::path::Path;

use rusty_contract::log::{Finding, LogError};
use thiserror::Error;

/// Longest line that is read, bytes. A scan of 1080 beams needs about 10 kB.
pub(super) const MAX_LINE_BYTES: usize = 1 << 20;

/// Longest piece of a file that a message repeats, characters.
const EXCERPT_CHARS: usize = 40;

/// Why an import failed. A failed import leaves no output file.
#[derive(Debug, Error)]
pub enum ImportError {
    /// A file, the recording or the run log, cannot be used.
    #[error("{path}: {problem}")]
    File {
        /// Path of the file.
        path: String,
        /// The value found, and the remedy.
        problem: String,
    },
    /// A line of the recording cannot be used.
    #[error("{path}: line {line}: {problem}")]
    Line {
        /// Path of the recording.
        path: String,
        /// Number of the line, from 1.
        line: u64,
        /// The field, its value, and the remedy.
        problem: String,
    },
    /// The recording has findings, and the import is strict.
    #[error(
        "{path}: import --strict refused the recording: {}; mend it, or import it without --strict",
        joined(findings)
    )]
    Strict {
        /// Path of the recording.
        path: String,
        /// Its defects.
        findings: Vec<Finding>,
    },
    /// The run log cannot be written.
    #[error(transparent)]
    Log(#[from] LogError),
}

impl ImportError {
    pub(super) fn file(path: &Path, problem: impl Display) -> Self {
        Self::File { path: path.display().to_string(), problem: problem.to_string() }
    }

    pub(super) fn line(path: &str, line: u64, problem: impl Display) -> Self {
        Self::Line { path: path.to_owned(), line, problem: problem.to_string() }
    }
}

fn joined(findings: &[Finding]) -> String {
    let texts: Vec<String> = findings.iter().map(ToString::to_string).collect();
    texts.join("; ")
}

/// `text`, or its beginning and its length if it is long.
pub(super) fn excerpt(text: &str) -> String {
    let chars = text.chars().count();
    if chars <= EXCERPT_CHARS {
        return text.to_owned();
    }
    let start: String = text.chars().take(EXCERPT_CHARS).collect();
    format!("{start}… ({chars} characters)")
}
