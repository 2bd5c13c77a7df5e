//! Who is compared, and how they can wait.

use std::fmt;

use clap::ValueEnum;
use rusty_link::WaitPolicy;
use serde::{Deserialize, Serialize};

/// A transport for frames and answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Contender {
    /// ZeroMQ over `ipc://`.
    Zmq,
    /// Zenoh: frames in its shared memory, the rest on a Unix socket.
    Zenoh,
    /// Unix sockets and nothing else.
    Uds,
    /// `sim-server` and its clients.
    Ours,
    /// iceoryx2 as ours uses it, without our protocol and without a world.
    Raw,
}

/// How a process waits for the other side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Wait {
    /// It sleeps in the kernel until it is woken: what people write.
    Block,
    /// It looks again and again and gives its core away between looks.
    Poll,
    /// It looks for a while, then sleeps: how `sim-server` comes; the others
    /// do not have it.
    Balanced,
}

impl Contender {
    /// Everyone, in the order in which they take turns.
    pub const ALL: [Self; 5] = [Self::Zmq, Self::Zenoh, Self::Uds, Self::Ours, Self::Raw];

    /// The word of the command line.
    pub fn word(self) -> &'static str {
        match self {
            Self::Zmq => "zmq",
            Self::Zenoh => "zenoh",
            Self::Uds => "uds",
            Self::Ours => "ours",
            Self::Raw => "raw",
        }
    }

    /// Why it cannot take part in this build or on this machine, and the
    /// remedy.
    pub fn missing(self) -> Option<String> {
        let without = |feature: &str| {
            Some(format!("this build is without it; build with --features {feature}"))
        };
        match self {
            Self::Zmq if !cfg!(feature = "zmq") => without("zmq"),
            Self::Zenoh if !cfg!(feature = "zenoh") => without("zenoh"),
            Self::Ours | Self::Raw => {
                let memory = rusty_link::memory_state();
                memory.problem.map(|problem| format!("{}: {problem}; mount it", memory.path))
            }
            _ => None,
        }
    }

    /// How it can wait.
    pub fn waits(self) -> &'static [Wait] {
        match self {
            Self::Ours | Self::Raw => &[Wait::Block, Wait::Poll, Wait::Balanced],
            _ => &[Wait::Block, Wait::Poll],
        }
    }
}

impl Wait {
    /// All ways.
    pub const ALL: [Self; 3] = [Self::Block, Self::Poll, Self::Balanced];

    /// The word of the command line.
    pub fn word(self) -> &'static str {
        match self {
            Self::Block => "block",
            Self::Poll => "poll",
            Self::Balanced => "balanced",
        }
    }

    /// The same in the words of `sim-server`.
    pub fn policy(self) -> WaitPolicy {
        match self {
            Self::Block => WaitPolicy::Block,
            Self::Poll => WaitPolicy::Spin,
            Self::Balanced => WaitPolicy::Balanced,
        }
    }
}

impl fmt::Display for Contender {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.word())
    }
}

impl fmt::Display for Wait {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.word())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_those_of_the_command_line() {
        for contender in Contender::ALL {
            assert_eq!(Contender::from_str(contender.word(), false), Ok(contender));
        }
        for wait in Wait::ALL {
            assert_eq!(Wait::from_str(wait.word(), false), Ok(wait));
        }
    }

    #[test]
    fn everyone_can_block_and_poll() {
        for contender in Contender::ALL {
            assert!(contender.waits().starts_with(&[Wait::Block, Wait::Poll]), "{contender}");
        }
    }
}
