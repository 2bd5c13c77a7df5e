//! What an export can fail with.

use std::path::Path;

use rusty_contract::Exit;
use rusty_contract::log::LogError;
use thiserror::Error;

/// What an export can fail with. Nothing is left of one that fails.
#[derive(Debug, Error)]
pub enum ExportError {
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The operating system says no.
    #[error("{path}: {error}")]
    Io {
        /// The file or folder.
        path: String,
        /// What it said.
        error: std::io::Error,
    },
    /// There is something already.
    #[error("{path} is there already; choose another -o, or replace it with --force")]
    InTheWay {
        /// The file.
        path: String,
    },
    /// Ctrl-C.
    #[error("{log}: interrupted, nothing is written; export it again from the start")]
    Interrupted {
        /// The log.
        log: String,
    },
}

impl ExportError {
    /// Wraps an error about a file.
    pub fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.display().to_string();
        move |error| Self::Io { path, error }
    }

    /// The exit code that goes with it.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::InTheWay { .. } => Exit::Usage,
            Self::Interrupted { .. } => Exit::Lost,
            Self::Log(_) | Self::Io { .. } => Exit::Failed,
        }
    }
}
