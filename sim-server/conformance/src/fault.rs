//! `Fault` and `Halt`: why a little run came to no good.

use std::time::Duration;

use rusty_contract::Refusal;
use thiserror::Error;

use rusty_engine::run::RunError;

/// What a client did that ends its run. The texts say what was seen.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Fault {
    /// It never asked to join.
    #[error("no request to join within {0:?}; its last lines: {1}")]
    NeverAsked(Duration, String),
    /// Its request is none.
    #[error("{0}")]
    BadRequest(Refusal),
    /// Its request to join does not carry the tag of its key.
    #[error("its request to join is not signed with the key from its standard input")]
    UnsignedRequest,
    /// Its answer does not carry the tag of its key.
    #[error("its answer to tick {0} is not signed with the key from its standard input")]
    Unsigned(u64),
    /// It joined but never said Ready.
    #[error("no Ready (answer kind 7) within {0:?} after its Start")]
    NeverReady(Duration),
    /// It did not answer.
    #[error("no answer to tick {tick} within {patience:?}{beside}")]
    NoAnswer {
        /// The tick.
        tick: u64,
        /// How long was waited.
        patience: Duration,
        /// What came instead.
        beside: String,
    },
    /// It left before the end.
    #[error("it left at tick {0}, before the run had ended")]
    Left(u64),
    /// It said itself that it failed.
    #[error("it reported a failure of its own at tick {tick}{how}")]
    GaveUp {
        /// The tick.
        tick: u64,
        /// How its process ended then.
        how: String,
    },
    /// Its process ended.
    #[error("its process ended {when}: {how}")]
    Ended {
        /// At which point of the run.
        when: String,
        /// Code or signal, and last lines.
        how: String,
    },
    /// The server that was to be killed did not come so far.
    #[error("the ticks before the kill were not answered; the server says {0:?}")]
    NotPlayed(String),
    /// It did not leave.
    #[error("no leave message (answer kind 5) within {0:?}")]
    NoLeave(Duration),
    /// Its process did not end.
    #[error("its process still ran {0:?} later and was killed")]
    NeverEnded(Duration),
}

/// Why a check came to no verdict.
#[derive(Debug)]
pub enum Halt {
    /// The client failed: that is a verdict.
    Client(Fault),
    /// The kit cannot work.
    Kit(Box<RunError>),
    /// The kit was asked to stop.
    Stopped,
}

impl From<Fault> for Halt {
    fn from(fault: Fault) -> Self {
        Self::Client(fault)
    }
}

impl<E: Into<RunError>> From<E> for Halt {
    fn from(error: E) -> Self {
        Self::Kit(Box::new(error.into()))
    }
}
