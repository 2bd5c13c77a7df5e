//! Why two estimators cannot be compared.

use rusty_contract::{Exit, FieldError};
use thiserror::Error;

use crate::sweep::SweepError;

/// Why two estimators cannot be compared.
#[derive(Debug, Error)]
pub enum VersusError {
    /// An option, or a file that is no table by its name.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A table cannot be read.
    #[error(transparent)]
    Table(#[from] SweepError),
    /// It is no table of runs.
    #[error("{path} {problem}; give a table that `sim-server sweep --out` wrote")]
    NoTable {
        /// The file.
        path: String,
        /// What is wrong with it.
        problem: String,
    },
    /// It is not clear who is meant.
    #[error("{path} {problem}; its estimators are {names}: say which with {option} NAME")]
    Who {
        /// The file.
        path: String,
        /// What is wrong.
        problem: String,
        /// Those that are there.
        names: String,
        /// The option that helps.
        option: &'static str,
    },
    /// An estimator compared with itself.
    #[error("A and B are both {name} of {path}: {remedy}, or give a second table")]
    Same {
        /// The estimator.
        name: String,
        /// The table.
        path: String,
        /// What helps, but for a second table.
        remedy: &'static str,
    },
    /// The settings differ.
    #[error(
        "{a} and {b} are sweeps of different runs: {difference} (there and there); sweep both \
         estimators with the same scenario and settings (two settings of one estimator are \
         compared by `sweep --ab`)"
    )]
    Settings {
        /// A's table.
        a: String,
        /// B's table.
        b: String,
        /// The first field that differs, and both values.
        difference: String,
    },
    /// The same seed, and not the same way.
    #[error(
        "seed {seed}{setting}: the robot drove {a_m} m in the run of A and {b_m} m in that of B, \
         in {ticks} ticks: they did not drive the same run, so nothing can be said of who is \
         better; sweep both with the same scenario, driver and program"
    )]
    Ways {
        /// The seed.
        seed: u64,
        /// What is set, in words.
        setting: String,
        /// A's way, m.
        a_m: f64,
        /// B's way, m.
        b_m: f64,
        /// Ticks of both.
        ticks: u64,
    },
    /// Nothing to pair.
    #[error("{a} and {b} share no seed in the same settings: sweep both with the same --seeds")]
    NoPair {
        /// A's table.
        a: String,
        /// B's table.
        b: String,
    },
    /// Nothing to be sure of.
    #[error(
        "no metric has a figure of both in more than one run of a setting, and one pair has no \
         interval: sweep more seeds, or compare another --metric (asked for: {metrics})"
    )]
    OnePair {
        /// What was asked for.
        metrics: String,
    },
}

impl VersusError {
    /// The exit code that goes with it: wrong input is wrong usage.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::Table(e) => e.exit(),
            _ => Exit::Usage,
        }
    }
}
