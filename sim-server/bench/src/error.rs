//! Why a bench could not measure.

use rusty_contract::Exit;
use rusty_engine::run::RunError;
use rusty_geometry::WorldError;
#[cfg(feature = "sweep")]
use rusty_study::sweep::SweepError;
use thiserror::Error;

/// Why a bench could not measure.
#[derive(Debug, Error)]
pub enum BenchError {
    /// A run could not be set up.
    #[error(transparent)]
    Run(RunError),
    /// A world of a bench.
    #[error(transparent)]
    World(WorldError),
    /// A sweep.
    #[error(transparent)]
    #[cfg(feature = "sweep")]
    Sweep(SweepError),
    /// Nothing was measured.
    #[error("nothing was measured: {0}")]
    Nothing(String),
}

impl<E: Into<RunError>> From<E> for BenchError {
    fn from(error: E) -> Self {
        Self::Run(error.into())
    }
}

impl BenchError {
    /// The exit code that goes with it.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::Run(e) => e.exit(),
            #[cfg(feature = "sweep")]
            Self::Sweep(e) => e.exit(),
            _ => Exit::Failed,
        }
    }
}
