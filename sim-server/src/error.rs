//! What a verb can fail with.

use rusty_contract::Exit;
use rusty_contract::log::LogError;
use rusty_contract::{FieldError, NameError};
use rusty_link::{DomainError, LinkError};
use rusty_sim::SimError;
use thiserror::Error;

use rusty_bench::BenchError;
use rusty_bench::page::PageError;
use rusty_conformance::ConformanceError;
use rusty_engine::confine::ConfineError;
use rusty_engine::run::{ChildrenError, LimitError};
use rusty_engine::scenario_file::SetupError;
use rusty_engine::source::ForkError;
use rusty_logs::export::ExportError;
use rusty_logs::folder::FolderError;
use rusty_logs::import::ImportError;
use rusty_logs::seal::SealError;
use rusty_study::sweep::SweepError;
use rusty_study::umbmark::LapError;
use rusty_study::versus::VersusError;

/// What a verb can fail with. Every text names place, value and remedy.
#[derive(Debug, Error)]
pub enum VerbError {
    /// A scenario or world.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// A field or argument.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A name.
    #[error(transparent)]
    Name(#[from] NameError),
    /// The world cannot be made.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A log.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A recording.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// Forking a run.
    #[error(transparent)]
    Fork(Box<ForkError>),
    /// Sealing a log.
    #[error(transparent)]
    Seal(#[from] SealError),
    /// A sweep.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// An export.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// A comparison of estimators.
    #[error(transparent)]
    Versus(#[from] VersusError),
    /// A lap of a UMBmark.
    #[error(transparent)]
    Lap(#[from] LapError),
    /// The run's place on this machine.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// Shared memory.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The folder of a run.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// A limit of this process.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// Signals cannot be listened for.
    #[error(
        "starting the thread that listens for signals failed: {0}; end other processes of this \
         user, or raise `ulimit -u`"
    )]
    Signals(std::io::Error),
    /// A participant cannot be started.
    #[error(transparent)]
    Children(#[from] ChildrenError),
    /// A participant cannot be confined.
    #[error(transparent)]
    Confine(#[from] ConfineError),
    /// The operating system says no.
    #[error("{path}: {error}")]
    Io {
        /// The file or folder.
        path: String,
        /// What it said.
        error: std::io::Error,
    },
    /// A file is there already.
    #[error("{path} is there already; give another path, or replace it with --force")]
    InTheWay {
        /// The file.
        path: String,
    },
    /// No randomness for the run's key.
    #[error("the operating system gives no random bytes for the run's key: {0}")]
    Random(getrandom::Error),
    /// A tick that the log does not have.
    #[error("{log} has no tick {tick}: it has {ticks} ticks, numbered from 0")]
    NoSuchTick {
        /// The log.
        log: String,
        /// Asked for.
        tick: u64,
        /// Present.
        ticks: u64,
    },
    /// A participant of a log did not take part when it was run again.
    #[error(
        "participant {name:?} could not be run again: {why}; see that its program still starts \
         as the log's roster says (`sim-server info LOG`)"
    )]
    NeverTookPart {
        /// Whose.
        name: String,
        /// What is known.
        why: String,
    },
    /// A bench.
    #[error(transparent)]
    Bench(Box<BenchError>),
    /// The conformance checks.
    #[error(transparent)]
    Conformance(Box<ConformanceError>),
    /// The page of benches.
    #[error(transparent)]
    Page(#[from] PageError),
    /// A drawing failed.
    #[error("cannot draw {path}: {why}")]
    Draw {
        /// The file.
        path: String,
        /// The plotting library's words.
        why: String,
    },
}

impl From<BenchError> for VerbError {
    fn from(error: BenchError) -> Self {
        Self::Bench(Box::new(error))
    }
}

impl From<ConformanceError> for VerbError {
    fn from(error: ConformanceError) -> Self {
        Self::Conformance(Box::new(error))
    }
}

impl From<ForkError> for VerbError {
    fn from(error: ForkError) -> Self {
        Self::Fork(Box::new(error))
    }
}

impl VerbError {
    /// Wraps an error about a file.
    pub fn io(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.display().to_string();
        move |error| Self::Io { path, error }
    }

    /// The exit code that goes with it: wrong input is wrong usage.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::Fork(e) => e.exit(),
            Self::Seal(e) => e.exit(),
            Self::Sweep(e) => e.exit(),
            Self::Export(e) => e.exit(),
            Self::Folder(e) => e.exit(),
            Self::Versus(e) => e.exit(),
            Self::Page(e) => e.exit(),
            Self::Bench(e) => e.exit(),
            Self::Conformance(e) => e.exit(),
            Self::Setup(_)
            | Self::Field(_)
            | Self::Name(_)
            | Self::Sim(_)
            | Self::Lap(_)
            | Self::InTheWay { .. }
            | Self::NoSuchTick { .. } => Exit::Usage,
            _ => Exit::Failed,
        }
    }
}
