//! What can be in the way of a run's folder.

use std::io;
use std::path::Path;

use rusty_contract::Exit;
use thiserror::Error;

/// Why a folder cannot be used for a run, or not be removed.
#[derive(Debug, Error)]
#[error("{path}{problem}")]
pub struct FolderError {
    /// The file or folder.
    pub path: String,
    /// What is in the way, and the remedy.
    pub problem: FolderProblem,
}

/// What is in the way of a run's folder: a predicate of its path.
#[derive(Debug, Error)]
pub enum FolderProblem {
    /// An error of the operating system.
    #[error(": {0}")]
    Io(#[from] io::Error),
    /// The path of a file.
    #[error(" is a file; give a folder with --out")]
    NotAFolder,
    /// A path that JSON cannot express.
    #[error(": the path of a run's folder must be UTF-8; give another folder with --out")]
    NotText,
    /// Another run, of this name.
    #[error(
        " holds the run {0:?}; give another --run or --out, or replace the whole folder with \
         --force (`sim-server runs` lists runs and removes them)"
    )]
    HoldsRun(String),
    /// A run of this name that has not ended.
    #[error(
        " is in use by the run {0:?}; give another --run or --out, wait for its end, or stop it \
         with `sim-server control {0} stop`"
    )]
    InUse(String),
    /// A file of this name, not written by a run.
    #[error(
        " holds {0:?}, which no run wrote, and is left as it is; give another folder, or move \
         that file away"
    )]
    Foreign(String),
    /// The log that is to be read.
    #[error(
        " holds the log that is read, {0}, and a new run there would write over it; give \
         another --run or --out"
    )]
    HoldsLog(String),
    /// A folder without a run.
    #[error(" is not the folder of a run; `sim-server runs` lists those that are")]
    NotARun,
}

impl FolderError {
    pub(super) fn at<P: Into<FolderProblem>>(path: &Path) -> impl FnOnce(P) -> Self {
        let path = path.display().to_string();
        move |problem| Self { path, problem: problem.into() }
    }

    /// Returns the exit code of this error.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self.problem {
            FolderProblem::Io(_) => Exit::Failed,
            _ => Exit::Usage,
        }
    }
}
