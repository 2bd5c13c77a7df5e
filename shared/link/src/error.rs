//! What can go wrong between two processes.

use rusty_contract::{KeyError, Refusal};
use thiserror::Error;

use crate::domain::DomainError;

/// What can go wrong between two processes.
#[derive(Debug, Error)]
pub enum LinkError {
    /// The run's folder, lock or memory.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// The transport failed.
    #[error("shared memory: cannot {doing}: {why}")]
    Transport {
        /// What was tried.
        doing: &'static str,
        /// The transport's own words.
        why: String,
    },
    /// Shared memory is full.
    #[error(
        "shared memory is full: {:.1} MB of /dev/shm are needed, {:.1} MB are free; end other \
         runs, remove dead ones with `sim-server clean`, delete files in /dev/shm, or give the \
         container more (docker run --shm-size=64m)",
        *needed_bytes as f64 / 1e6, *free_bytes as f64 / 1e6
    )]
    NoRoom {
        /// Bytes that are needed at once.
        needed_bytes: u64,
        /// Bytes that are free.
        free_bytes: u64,
    },
    /// The server said no.
    #[error("refused: {0}")]
    Refused(#[from] Refusal),
    /// No process answered a request.
    #[error(
        "run {run:?}: no answer to the request within {seconds:.0} s; is its server \
         stopped or overloaded? (process {pid})"
    )]
    NoAnswer {
        /// The run.
        run: String,
        /// How long it was waited.
        seconds: f64,
        /// The server's process.
        pid: u32,
    },
    /// The server does not describe its run to an observer.
    #[error("the run cannot be observed: {why}")]
    Unobserved {
        /// The server's reason.
        why: String,
    },
    /// The server's process has ended without announcing the end of the run.
    #[error("the server (process {pid}) is gone: it ended without announcing the end of the run")]
    ServerGone {
        /// Its process.
        pid: u32,
    },
    /// The run goes on without this participant.
    #[error(
        "{name:?} was dropped from this run: the server did not wait for it any longer, or could \
         not use its answer (its own report says which), and went on; it cannot come back into \
         the run"
    )]
    Dropped {
        /// Its name.
        name: String,
    },
    /// This process was asked to stop.
    #[error("stopped on request")]
    Stopped,
    /// A frame that the server did not send, or not to this participant.
    #[error(
        "tick {tick}: the frame is not signed with this participant's key: a process of this run \
         forged it or changed it in shared memory; do not trust this run, and confine its \
         participants (sandbox = \"required\")"
    )]
    Unsigned {
        /// The tick that the frame carries.
        tick: u64,
    },
    /// A frame whose bytes do not have the digest that the server signed.
    #[error(
        "tick {tick}: the frame's bytes have the digest {found:016x}, the server signed \
         {signed:016x}: a process of this run changed them in shared memory; do not trust this run"
    )]
    Changed {
        /// The tick that the frame carries.
        tick: u64,
        /// The digest that the server signed.
        signed: u64,
        /// The digest of the bytes.
        found: u64,
    },
    /// The credentials of a participant started by hand.
    #[error("{path}: {error}")]
    Credentials {
        /// The file.
        path: String,
        /// What is wrong with it.
        error: String,
    },
    /// There is no key to sign control requests with.
    #[error(
        "run {run:?}: its control key cannot be read from {path}: {error}; only the user who \
         serves a run controls it"
    )]
    NoControlKey {
        /// The run.
        run: String,
        /// The file.
        path: String,
        /// What the operating system says.
        error: String,
    },
    /// The key does not fit.
    #[error(transparent)]
    Key(#[from] KeyError),
}

impl LinkError {
    /// Wraps an error of the transport.
    pub(crate) fn transport<E: std::fmt::Debug>(doing: &'static str) -> impl FnOnce(E) -> Self {
        move |e| Self::Transport { doing, why: format!("{e:?}") }
    }
}
