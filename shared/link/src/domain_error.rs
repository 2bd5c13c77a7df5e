//! Why a run's place on this machine cannot be used.

use std::path::Path;

use thiserror::Error;

/// Why a domain cannot be used.
#[derive(Debug, Error)]
pub enum DomainError {
    /// A living server has this name.
    #[error(
        "run {run:?} is in use by process {pid}; choose another name with --run, or end that \
         run first"
    )]
    InUse {
        /// The run.
        run: String,
        /// The server's process.
        pid: u32,
    },
    /// No server has this name.
    #[error("no run {run:?} is being served (looked in {folder}); {remedy}")]
    NoSuchRun {
        /// The run.
        run: String,
        /// Where it would be.
        folder: String,
        /// What to do.
        remedy: String,
    },
    /// The operating system says no.
    #[error("{path}: {doing}: {error}")]
    Io {
        /// The file or folder.
        path: String,
        /// What was tried.
        doing: &'static str,
        /// What it said.
        error: std::io::Error,
    },
    /// A folder of ours belongs to another user, is a link, or is open to others.
    #[error(
        "{path} must be a folder that belongs to you (user {me}) and that nobody else can write \
         to; it belongs to user {owner}, or is a link, or is open to others: remove it"
    )]
    NotYours {
        /// The folder.
        path: String,
        /// Its owner.
        owner: u32,
        /// This user.
        me: u32,
    },
}

pub(crate) fn io(path: &Path, doing: &'static str) -> impl FnOnce(std::io::Error) -> DomainError {
    let path = path.display().to_string();
    move |error| DomainError::Io { path, doing, error }
}
