//! All figures that are computed from poses, one function for each: the scorer, sweeps
//! and comparisons of estimators use the same ones. docs/metrics.md explains them.
//!
//! * Of one run: [`meter`] with [`errors`], [`trajectory`], [`alignment`], [`mod@nees`],
//!   [`consistency`], [`convergence`], [`held`], [`goals`];
//! * of many runs: [`moments`], [`paired`], [`sign_test`], [`student`], [`power_law`];
//! * of any numbers: [`quantiles`], [`series`], [`batches`], [`chi_square`], [`allan`].
//!
//! Sums are taken in the order of the ticks, so that a live run, its log and a sweep
//! give the same bits.

pub mod alignment;
pub mod allan;
pub mod batches;
pub mod chi_square;
mod compute;
pub mod consistency;
pub mod convergence;
pub mod errors;
pub mod goals;
pub mod held;
pub mod meter;
pub mod moments;
pub mod nees;
pub mod paired;
pub mod path;
pub mod power_law;
pub mod quantiles;
pub mod scored;
pub mod series;
pub mod sign_test;
pub mod student;
pub mod trajectory;
mod wrong;

pub use allan::{Allan, AllanDeviation};
pub use errors::Errors;
pub use goals::Goals;
pub use held::Held;
pub use meter::{Given, Meter, Moment, Planned, Yardstick};
pub use moments::{Moments, Running, correlation};
pub use nees::nees;
pub use paired::Paired;
pub use path::PathLength;
pub use power_law::PowerLaw;
pub use quantiles::{Quantiles, percentile};
pub use scored::{Scored, heading_error_rad, position_error_m};
pub use sign_test::SignTest;
