//! Why a recording cannot be imported: place, value and remedy.

use std::io;

use rusty_contract::FieldError;
use rusty_contract::log::{Finding, LogError};
use thiserror::Error;

/// Longest line that is read, bytes. A scan of 1080 beams needs about 10 kB.
pub(super) const MAX_LINE_BYTES: usize = 1 << 20;

/// Longest piece of a file that a message repeats, characters.
const EXCERPT_CHARS: usize = 40;

/// A field of a message that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{message} field {field} ({name}) = {found:?}: {problem}; {remedy}")]
pub struct BadField {
    /// Type of the message.
    pub message: &'static str,
    /// The field, from 1 for the first after the message's name.
    pub field: usize,
    /// What it means.
    pub name: String,
    /// The text found, shortened if long.
    pub found: String,
    /// What is wrong with it.
    pub problem: &'static str,
    /// What to do.
    pub remedy: &'static str,
}

/// Why an import failed. A failed import leaves no output file.
#[derive(Debug, Error)]
pub enum ImportError {
    /// The operating system does not open the recording.
    #[error("{path}: {error}; give the path of a CARMEN log, plain or gzip")]
    Open {
        /// The recording.
        path: String,
        /// What the operating system said.
        error: io::Error,
    },
    /// Reading or unpacking the recording fails on the way.
    #[error(
        "{path}: after line {line} ({bytes} bytes unpacked): {error}; the file is damaged \
         there, or its disk is: fetch it again"
    )]
    Read {
        /// The recording.
        path: String,
        /// Complete lines before.
        line: u64,
        /// Bytes in those lines.
        bytes: u64,
        /// What the operating system, or the decompressor, said.
        error: io::Error,
    },
    /// The recording is a pipe, a device or a folder.
    #[error(
        "{path}: this is no regular file; an import reads its input four times, so write it to a \
         file first"
    )]
    NotAFile {
        /// The recording.
        path: String,
    },
    /// The gzip stream ends too early.
    #[error(
        "{path}: the gzip stream is cut off after line {line} ({bytes} bytes unpacked); fetch \
         the file again, or unpack what there is (gzip -dc), delete the last, incomplete line \
         and import that"
    )]
    Truncated {
        /// The recording.
        path: String,
        /// Complete lines before the cut.
        line: u64,
        /// Bytes in those lines.
        bytes: u64,
    },
    /// A line that is none.
    #[error(
        "{path}: line {line} is longer than {MAX_LINE_BYTES} bytes; this is no CARMEN log, or \
         its line ends are lost: end each message with a newline"
    )]
    LongLine {
        /// The recording.
        path: String,
        /// The line, from 1.
        line: u64,
    },
    /// A message has too few or too many fields.
    #[error(
        "{path}: line {line}: {message} has {found} fields after its name, {expected} are \
         needed ({form}); the line is cut off or mixed up: correct or delete it"
    )]
    FieldCount {
        /// The recording.
        path: String,
        /// The line, from 1.
        line: u64,
        /// Type of the message.
        message: &'static str,
        /// Fields found.
        found: usize,
        /// Fields of such a message.
        expected: usize,
        /// The form of such a message.
        form: &'static str,
    },
    /// A field cannot be used.
    #[error("{path}: line {line}: {field}")]
    Field {
        /// The recording.
        path: String,
        /// The line, from 1.
        line: u64,
        /// The field.
        field: Box<BadField>,
    },
    /// Scans of different size.
    #[error(
        "{path}: line {line}: FLASER has {found} beams, the first scan (line {first_line}) has \
         {first}; a run has one LiDAR: split the recording where the number changes"
    )]
    BeamsChange {
        /// The recording.
        path: String,
        /// The line, from 1.
        line: u64,
        /// Beams there.
        found: usize,
        /// Line of the first scan.
        first_line: u64,
        /// Beams of the first scan.
        first: usize,
    },
    /// Nothing that a wheel could have counted.
    #[error(
        "{path}: no odometry in {lines} lines (no ODOM message, no FLASER with an odometry pose \
         of its own){hint}; import a CARMEN log with ODOM lines"
    )]
    NoOdometry {
        /// The recording.
        path: String,
        /// Lines read.
        lines: u64,
        /// What was there instead.
        hint: String,
    },
    /// What was found gives a configuration that no run can have.
    #[error("{path}: {error}")]
    Config {
        /// The recording.
        path: String,
        /// Field, value and remedy.
        error: FieldError,
    },
    /// The recording was written to meanwhile.
    #[error("{path}: the file changed while it was read; import it again when it is complete")]
    Changed {
        /// The recording.
        path: String,
    },
    /// The recording has findings, and the import is strict.
    #[error(
        "{path}: import --strict refused the recording: {}; mend it, or import it without --strict",
        joined(findings)
    )]
    Strict {
        /// The recording.
        path: String,
        /// Its defects.
        findings: Vec<Finding>,
    },
    /// Input and output are one file.
    #[error("{path}: input and output are the same file; give the run log another name")]
    SameFile {
        /// The file.
        path: String,
    },
    /// The operating system does not create or rename the run log.
    #[error("{path}: {action}: {error}; choose a folder that can be written to")]
    Output {
        /// The run log.
        path: String,
        /// What was tried.
        action: &'static str,
        /// What it said.
        error: io::Error,
    },
    /// The run log cannot be written.
    #[error(transparent)]
    Log(#[from] LogError),
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
