//! What can be in the way of a run's folder.

use std::path::Path;

use rusty_contract::Exit;
use thiserror::Error;

/// Why a folder cannot be used for a run, or not be removed.
#[derive(Debug, Error)]
pub enum FolderError {
    /// The operating system says no.
    #[error("{path}: {error}")]
    Io {
        /// The file or folder.
        path: String,
        /// What it said.
        error: std::io::Error,
    },
    /// A file is in its place.
    #[error("{path} is a file; give a folder with --out")]
    NotAFolder {
        /// The path.
        path: String,
    },
    /// Its path cannot be written as text.
    #[error("{path}: the path of a run's folder must be UTF-8; give another folder with --out")]
    NotText {
        /// The path, with marks for what is not text.
        path: String,
    },
    /// There is a run in it.
    #[error(
        "{path} holds the run {run:?}; give another --run or --out, or replace the whole folder \
         with --force (`sim-server runs` lists runs and removes them)"
    )]
    HoldsRun {
        /// The folder.
        path: String,
        /// The run.
        run: String,
    },
    /// Its run goes on.
    #[error(
        "{path} is in use by the run {run:?}; give another --run or --out, wait for its end, or \
         stop it with `sim-server control {run} stop`"
    )]
    InUse {
        /// The folder.
        path: String,
        /// The run.
        run: String,
    },
    /// There is something in it that no run wrote.
    #[error(
        "{path} holds {file:?}, which no run wrote, and is left as it is; give another folder, or \
         move that file away"
    )]
    Foreign {
        /// The folder.
        path: String,
        /// The first such file.
        file: String,
    },
    /// The log that is to be read is in it.
    #[error(
        "{path} holds the log that is read, {log}, and a new run there would write over it; give \
         another --run or --out"
    )]
    HoldsLog {
        /// The folder.
        path: String,
        /// The log.
        log: String,
    },
    /// It is not the folder of a run.
    #[error("{path} is not the folder of a run; `sim-server runs` lists those that are")]
    NotARun {
        /// The path.
        path: String,
    },
}

impl FolderError {
    pub(super) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.display().to_string();
        move |error| Self::Io { path, error }
    }

    /// The exit code that goes with it.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::Io { .. } => Exit::Failed,
            _ => Exit::Usage,
        }
    }
}
