//! The SDK: everything that the author of a participant needs.
//!
//! A filter of your own is a plain loop over a [`Session`]:
//!
//! ```no_run
#![doc = include_str!("../examples/01_first_estimator.rs")]
//! ```
//!
//! or a type with one function ([`Filter`]) and a `main` of one line ([`run`]).
//!
//! The answer is the acknowledgement: the next tick happens when everyone has
//! answered this one. A tick that is dropped abstains; an estimator that
//! panics says so. The same binary works on a log without a server (`--log`).
//!
//! Nothing here can name the simulator: models are beliefs about the world,
//! and this crate does not depend on it:
//!
//! ```compile_fail,E0432
//! use rusty_sim::Sim;
//! ```
//!
//! Without the feature `link` (on by default) only the types of filters are there, for
//! programs without a run: WebAssembly, for example.
//!
//! Rays and walls for a sensor model are in [`geometry`], which knows no noise.

#[cfg(feature = "link")]
mod args;
pub mod dead_reckoning;
mod error;
mod filter;
mod held_frame;
#[cfg(feature = "link")]
mod log_session;
#[cfg(feature = "link")]
mod places;
mod random;
#[cfg(feature = "link")]
pub mod recorder;
#[cfg(feature = "link")]
mod run;
#[cfg(feature = "link")]
mod session;
#[cfg(feature = "link")]
pub mod showing;
mod tick;

#[cfg(feature = "link")]
pub use args::{ClientArgs, Usage, parsed, with_negative_numbers};
pub use error::ClientError;
pub use filter::Filter;
#[cfg(feature = "link")]
pub use held_frame::HeldFrame;
#[cfg(feature = "link")]
pub use places::output_folder;
pub use random::Random;
#[cfg(feature = "link")]
pub use recorder::{Recorder, run_recorder};
#[cfg(feature = "link")]
pub use run::{run, run_from};
#[cfg(feature = "link")]
pub use session::{Arrival, Session, stop_by_signal};
pub use tick::Tick;

// The crates that filters need next to this one, in the versions that fit it.
pub use clap;
pub use nalgebra;
pub use rusty_geometry as geometry;

/// All that a filter usually needs.
pub mod prelude {
    #[cfg(feature = "link")]
    pub use crate::{ClientArgs, Session};
    pub use crate::{ClientError, Filter, Random, Tick};
    pub use rusty_contract::{BeliefKind, WeightedPose};
    pub use rusty_contract::{Estimate, Exit, NominalRobot, Reply, Start};
    pub use rusty_geometry::{DiffDrive, EncoderCounts, SE2, Twist, World, odometry_delta};
}
