//! What can go wrong in a measurement.

use std::path::{Path, PathBuf};

use rusty_contract::AnswerError;
use rusty_link::LinkError;
use thiserror::Error;

/// Why there is no measurement.
#[derive(Debug, Error)]
pub enum BenchError {
    /// A library that carries frames or answers failed.
    #[error("{library}: cannot {what}: {problem}")]
    Transport {
        library: &'static str,
        /// What it was asked for.
        what: &'static str,
        problem: String,
    },
    /// Something came in a size that nothing has.
    #[error("{library}: {what} of {bytes} bytes, not {expected}")]
    Size {
        library: &'static str,
        /// What it was to be.
        what: &'static str,
        bytes: usize,
        /// The size of such a thing.
        expected: usize,
    },
    /// A frame came out of turn.
    #[error("client {place}: frame {tick} came where frame {expected} was due")]
    Frame { place: u32, tick: u64, expected: u64 },
    /// An answer is not one to the frame that is out.
    #[error("tick {tick}: the answer of client {place} {problem}")]
    Answer {
        /// The frame that is out.
        tick: u64,
        place: u32,
        /// What is wrong with it.
        problem: String,
    },
    /// An answer has an invalid number.
    #[error("tick {tick}: {error}")]
    Number {
        /// The frame that is out.
        tick: u64,
        error: AnswerError,
    },
    /// A file or process of the operating system.
    #[error("{path}: {error}", path = path.display())]
    Io { path: PathBuf, error: std::io::Error },
    /// The scenario cannot be set up.
    #[error(transparent)]
    Scenario(#[from] rusty_engine::scenario_file::SetupError),
    /// The world cannot be set up.
    #[error(transparent)]
    World(#[from] rusty_sim::SimError),
    #[error(transparent)]
    Link(#[from] LinkError),
    #[error(transparent)]
    Client(#[from] rusty_clients::ClientError),
    /// A run of `sim-server` could not be made or did not end well.
    #[error("sim-server: {0}")]
    Ours(String),
    /// A server's process ended without a result.
    #[error("{0}")]
    NoResult(String),
    #[error("interrupted")]
    Stopped,
}

impl BenchError {
    /// For `map_err`: names the library and what it was asked for.
    pub fn of<E: std::fmt::Display>(
        library: &'static str,
        what: &'static str,
    ) -> impl FnOnce(E) -> Self {
        move |error| Self::Transport { library, what, problem: error.to_string() }
    }

    /// For `map_err`: names the file.
    pub fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        move |error| Self::Io { path: path.to_owned(), error }
    }
}
