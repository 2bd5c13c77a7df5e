//! Scoring a run: what was true, what was believed, how far apart, as numbers
//! and as a picture.
//!
//! In reading order:
//!
//! * [`trace`]: a run as it is drawn, filled tick by tick;
//! * [`keeper`]: the same of a run of any length, in memory of a fixed size;
//! * [`stops`]: fewer ticks, with covariances and scans;
//! * [`beliefs`]: what filters held possible, at some ticks;
//! * [`metrics`]: one [`Score`](rusty_contract::score::Score) per estimator; what
//!   is in it lies in `statistics` (rows of errors), `trajectory`, `alignment`,
//!   `consistency`, `batches`, `convergence` and `compute`;
//! * [`Held`]: in how many ticks a wall held the robot;
//! * [`yardstick`]: what the estimates are judged by;
//! * [`bands`]: what a covariance promises;
//! * [`picture`]: the run on one page, as SVG; its parts are `map`, `chart` and
//!   `panel` on a common `timeline`, its tools those of [`rusty_plot`], which also
//!   makes pixels of it.
//!
//! Nothing here reads a clock or a file: the same trace gives the same bytes.

mod alignment;
pub mod bands;
mod batches;
pub mod beliefs;
pub(crate) mod chart;
mod compute;
mod consistency;
mod convergence;
mod held;
pub mod keeper;
pub(crate) mod map;
pub mod metrics;
mod panel;
pub mod picture;
mod scored;
mod statistics;
pub mod stops;
pub(crate) mod timeline;
pub mod trace;
mod trajectory;
pub mod yardstick;

pub use beliefs::{BeliefKeeper, BeliefMoment};
pub use held::Held;
pub use keeper::TraceKeeper;
pub use metrics::{Given, Meter, Moment, Planned, score};
pub use picture::svg;
pub use trace::RunTrace;
pub use yardstick::Yardstick;
