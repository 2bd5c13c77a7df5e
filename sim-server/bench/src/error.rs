//! Why a bench could not measure.

use rusty_contract::log::LogError;
use rusty_contract::{Exit, FieldError};
use rusty_engine::confine::ConfineError;
use rusty_engine::run::{ChildrenError, LimitError};
use rusty_engine::scenario_file::SetupError;
use rusty_geometry::WorldError;
use rusty_link::{DomainError, LinkError};
use rusty_sim::SimError;
use rusty_study::sweep::SweepError;
use thiserror::Error;

/// Why a bench could not measure.
#[derive(Debug, Error)]
pub enum BenchError {
    /// A scenario or world.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// A field or argument.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The world cannot be made.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A world of a bench.
    #[error(transparent)]
    World(#[from] WorldError),
    /// A log.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A sweep.
    #[error(transparent)]
    Sweep(#[from] SweepError),
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
    /// A participant cannot be confined.
    #[error(transparent)]
    Confine(#[from] ConfineError),
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
    /// Nothing was measured.
    #[error("nothing was measured: {0}")]
    Nothing(String),
}

impl BenchError {
    /// Wraps an error about a file.
    pub fn io(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.display().to_string();
        move |error| Self::Io { path, error }
    }

    /// The exit code that goes with it: wrong input is wrong usage.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::Sweep(e) => e.exit(),
            Self::Setup(_) | Self::Field(_) | Self::Sim(_) => Exit::Usage,
            _ => Exit::Failed,
        }
    }
}
