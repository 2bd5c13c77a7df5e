//! What a sweep can fail with.

use rusty_contract::Exit;
use rusty_engine::run::RunError;
use thiserror::Error;

use super::incomplete::Incomplete;

/// What a sweep can fail with.
#[derive(Debug, Error)]
pub enum SweepError {
    /// A run could not be set up.
    #[error(transparent)]
    Run(RunError),
    /// There is no thread for a worker.
    #[error("starting a worker failed: {0}; give fewer with --jobs, or raise `ulimit -u`")]
    Thread(std::io::Error),
    /// There is something already.
    #[error("{path} {what}; {remedy}")]
    InTheWay {
        /// The file.
        path: String,
        /// What is with it.
        what: String,
        /// What helps.
        remedy: &'static str,
    },
    /// A sweep that was interrupted was another one.
    #[error(
        "{path} is of another sweep: {difference} (there and here); repeat its options to go on \
         with it, or --force to begin anew"
    )]
    Other {
        /// The file.
        path: String,
        /// The first field that differs, and both values.
        difference: String,
    },
    /// A file that should hold a sweep does not.
    #[error("{path}: {problem}; make it again with `sim-server sweep … --force`")]
    NoSweep {
        /// The file.
        path: String,
        /// What was found.
        problem: String,
    },
    /// A table or picture cannot be made.
    #[error("{path} cannot be written: {problem}")]
    Table {
        /// The file.
        path: String,
        /// The library's words.
        problem: String,
    },
    /// A table cannot be read.
    #[error("{path} cannot be read: {problem}; give a table that `sim-server sweep --out` wrote")]
    Unreadable {
        /// The file.
        path: String,
        /// The library's words.
        problem: String,
    },
    /// A manifest cannot be used.
    #[error("{path} {problem}; {remedy}")]
    Manifest {
        /// The file.
        path: String,
        /// What is wrong with it.
        problem: String,
        /// What helps.
        remedy: &'static str,
    },
    /// This machine makes other settings of the options in a manifest.
    #[error(
        "the settings of the sweep differ on this machine: {difference} (manifest and here); use \
         the sim-server and the files that planned it, or plan again with `sim-server sweep plan`"
    )]
    OtherSettings {
        /// The first field that differs, and both values.
        difference: String,
    },
    /// This machine computes other bits.
    #[error(
        "golden run {name} differs on this machine: expected {expected}, got {found}; use the \
         build that planned the sweep, and check both machines with `sim-server doctor`"
    )]
    OtherBits {
        /// The golden run.
        name: String,
        /// Its digest in the manifest.
        expected: String,
        /// Its digest here.
        found: String,
    },
    /// Parts of shards are missing or damaged.
    #[error("{0}")]
    Incomplete(Incomplete),
    /// A run with clients could not be made.
    #[error("seed {seed}{cell}: the run could not be made: {why}")]
    Launch {
        /// The seed.
        seed: u64,
        /// The swept fields, in words.
        cell: String,
        /// Its last lines.
        why: String,
    },
    /// A participant that stays for many runs does not begin them alike.
    #[error(
        "repeating a run failed: {names}, seed {seed}{cell}: expected the answers of its first \
         run, got {found}; a program that takes part in several runs makes its state anew for \
         each and uses no clock and no other random numbers: correct it, or have it take part \
         in one run only"
    )]
    CarriedOver {
        /// Names in the roster.
        names: String,
        /// The seed.
        seed: u64,
        /// The swept fields, in words.
        cell: String,
        /// What differed.
        found: String,
    },
    /// The process of a participant failed after the last run.
    #[error("ending the programs of the runs failed: {name}: {how}; the rows are complete")]
    Ended {
        /// Name in the roster.
        name: String,
        /// How it ended.
        how: String,
    },
}

impl<E: Into<RunError>> From<E> for SweepError {
    fn from(error: E) -> Self {
        Self::Run(error.into())
    }
}

impl SweepError {
    /// Wraps an error about a file.
    pub fn io(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> Self {
        let wrap = RunError::io(path);
        |error| wrap(error).into()
    }

    /// The exit code that goes with it: wrong input is wrong usage.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::Run(e) => e.exit(),
            Self::InTheWay { .. }
            | Self::Other { .. }
            | Self::NoSweep { .. }
            | Self::Manifest { .. }
            | Self::OtherSettings { .. } => Exit::Usage,
            Self::OtherBits { .. } => Exit::NotBitExact,
            Self::Table { .. }
            | Self::Unreadable { .. }
            | Self::Thread(_)
            | Self::Incomplete(_)
            | Self::Launch { .. }
            | Self::Ended { .. } => Exit::Failed,
            Self::CarriedOver { .. } => Exit::NotBitExact,
        }
    }
}
