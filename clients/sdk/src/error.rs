//! What can go wrong for a participant.

use rusty_contract::belief::BeliefFileError;
use rusty_contract::output::visible;
use rusty_contract::{
    AnswerError, BlindKeyError, CredentialsError, Exit, FieldError, KeyError, log::LogError,
};
#[cfg(feature = "link")]
use rusty_link::LinkError;
use thiserror::Error;

/// What can go wrong for a participant. `Debug` reads like `Display`, so that
/// `fn main() -> Result<(), ClientError>` speaks to a person.
#[derive(Error)]
pub enum ClientError {
    /// Joining or talking to the server.
    #[cfg(feature = "link")]
    #[error(transparent)]
    Link(#[from] LinkError),
    /// Reading or writing a log.
    #[error(transparent)]
    Log(#[from] LogError),
    /// An invalid answer.
    #[error("tick {tick}: {error}")]
    Answer {
        /// The tick that was to be answered.
        tick: u64,
        /// What is wrong with the answer.
        error: AnswerError,
    },
    /// The key does not fit, or there is none.
    #[error("key: {0}")]
    Key(#[from] KeyError),
    /// What was told by the private channel cannot be read.
    #[error(transparent)]
    Credentials(#[from] CredentialsError),
    /// The key of a blind log does not fit.
    #[error("{path}: {error}")]
    BlindKey {
        /// The key's file.
        path: String,
        /// What is wrong.
        error: BlindKeyError,
    },
    /// An argument that cannot be used.
    #[error(transparent)]
    Argument(#[from] FieldError),
    /// A key is needed.
    #[error("{0} holds the key to the truth, but none was given; use --key-file or --key-stdin")]
    NoKey(String),
    /// The operating system says no.
    #[error("{path}: {error}")]
    Io {
        /// The file.
        path: String,
        /// What it said.
        error: std::io::Error,
    },
    /// The answers on a log, which go to stdout, cannot be written.
    #[error(
        "writing the answers to stdout failed: {0}; give a file with --out, or a stdout that can \
         be written"
    )]
    Stdout(std::io::Error),
    /// A file is there already.
    #[error("{path} is there already; give another path, or replace it with --force")]
    InTheWay {
        /// The file.
        path: String,
    },
    /// A log cannot be written any further.
    #[error(
        "{path}: {error}; {ticks} ticks had been taken, and the log reads up to the last one that is whole in it: make room there, or give the logger another folder with --out, and run again"
    )]
    Logging {
        /// The log.
        path: String,
        /// How many ticks had been taken when it was noticed.
        ticks: u64,
        /// What the operating system said.
        error: std::io::Error,
    },
    /// The log has no participant of this name, or holds something unusable.
    #[error("{0}")]
    Unusable(String),
    /// Options that do not fit each other, the run or the log.
    #[error("{0}")]
    Usage(String),
    /// There is nothing to write with `--beliefs`.
    #[error(
        "{0} shows no belief: --beliefs FILE is for filters that hold more than one pose possible, \
         on a log, and for `score --log LOG`; leave it out"
    )]
    ShowsNone(String),
    /// A file of beliefs.
    #[error("{path}: {error}")]
    Beliefs {
        /// The file.
        path: String,
        /// What is wrong.
        error: BeliefFileError,
    },
    /// The estimator panicked; the panic itself is on stderr.
    #[error("the estimator panicked at tick {tick}; its message is above")]
    Panicked {
        /// The tick it was working on.
        tick: u64,
    },
    /// A picture could not be drawn.
    #[error("the picture could not be drawn: {0}")]
    Picture(String),
}

impl std::fmt::Debug for ClientError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&visible(&self.to_string()))
    }
}

impl ClientError {
    /// Wraps an error about a file.
    pub fn io(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.display().to_string();
        move |error| Self::Io { path, error }
    }

    /// The exit code that goes with it.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::Argument(_) | Self::Usage(_) | Self::ShowsNone(_) | Self::InTheWay { .. } => {
                Exit::Usage
            }
            #[cfg(feature = "link")]
            Self::Link(LinkError::Dropped { .. }) => Exit::Lost,
            _ => Exit::Failed,
        }
    }
}
