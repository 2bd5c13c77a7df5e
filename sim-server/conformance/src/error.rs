//! Why the conformance checks could not be made.

use rusty_contract::{Exit, FieldError, NameError};
use rusty_engine::run::{ChildrenError, LimitError};
use rusty_engine::scenario_file::SetupError;
use rusty_link::{DomainError, LinkError};
use rusty_sim::SimError;
use thiserror::Error;

/// Why the checks could not be made: nothing is known of the client then.
#[derive(Debug, Error)]
pub enum ConformanceError {
    /// The scenario of the checks.
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
    /// The run's place on this machine.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// Shared memory.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// A limit of this process.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// The client cannot be started.
    #[error(transparent)]
    Children(#[from] ChildrenError),
    /// The operating system refused.
    #[error("{path}: {error}")]
    Io {
        /// The file or folder.
        path: String,
        /// The system's error.
        error: std::io::Error,
    },
    /// No randomness for the run's key.
    #[error("the operating system gives no random bytes for the run's key: {0}")]
    Random(getrandom::Error),
}

impl ConformanceError {
    /// Wraps an error about a file.
    pub fn io(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.display().to_string();
        move |error| Self::Io { path, error }
    }

    /// The exit code that goes with it: wrong input is wrong usage.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::Setup(_) | Self::Field(_) | Self::Sim(_) => Exit::Usage,
            _ => Exit::Failed,
        }
    }
}
