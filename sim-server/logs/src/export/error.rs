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
    /// An error of the operating system about a file or folder.
    #[error("{0}: {1}")]
    Io(String, std::io::Error),
    /// A file that is there already.
    #[error("{0} is there already; choose another -o, or replace it with --force")]
    InTheWay(String),
    /// Ctrl-C during the export of a log.
    #[error("{0}: interrupted, nothing is written; export it again from the start")]
    Interrupted(String),
}

impl ExportError {
    /// Wraps an error about a file.
    pub fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.display().to_string();
        move |error| Self::Io(path, error)
    }

    /// The exit code that goes with it.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::InTheWay(_) => Exit::Usage,
            Self::Interrupted(_) => Exit::Lost,
            Self::Log(_) | Self::Io(..) => Exit::Failed,
        }
    }
}
