//! Why a run cannot be set up.

use std::path::Path;

use rusty_contract::log::LogError;
use rusty_contract::{Exit, FieldError, NameError};
use rusty_link::{DomainError, LinkError};
use rusty_sim::SimError;
use thiserror::Error;

use super::{ChildrenError, LimitError};
use crate::scenario_file::SetupError;

/// Why a run cannot be set up. Every text names place, value and remedy.
#[derive(Debug, Error)]
pub enum RunError {
    /// A scenario or world.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// A field or argument.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The name of a run.
    #[error(transparent)]
    Name(#[from] NameError),
    /// The world cannot be made.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A log.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The run's place on this machine.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// Shared memory.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// A limit of this process.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// A participant cannot be started.
    #[error(transparent)]
    Children(#[from] ChildrenError),
    /// Signals cannot be listened for.
    #[error(
        "starting the thread that listens for signals failed: {0}; end other processes of this \
         user, or raise `ulimit -u`"
    )]
    Signals(std::io::Error),
    /// The operating system refused.
    #[error("{path}: {error}")]
    Io {
        /// The file or folder.
        path: String,
        /// The system's error.
        error: std::io::Error,
    },
    /// The folder of the run cannot be made.
    #[error("the folder {path} cannot be made: {error}; give one that can with --out")]
    Folder {
        /// The folder.
        path: String,
        /// The system's error.
        error: std::io::Error,
    },
    /// No randomness for the run's key.
    #[error("the operating system gives no random bytes for the run's key: {0}")]
    Random(#[from] getrandom::Error),
}

impl RunError {
    /// Wraps an error about a file.
    pub fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.display().to_string();
        move |error| Self::Io { path, error }
    }

    /// The exit code that goes with it: wrong input is wrong usage.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::Setup(_) | Self::Field(_) | Self::Name(_) | Self::Sim(_) => Exit::Usage,
            _ => Exit::Failed,
        }
    }
}
