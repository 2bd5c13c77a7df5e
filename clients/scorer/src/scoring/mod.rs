//! Scoring a run: what was true, what was believed, how far apart, as numbers
//! and as a picture.
//!
//! In reading order:
//!
//! * [`trace`]: a run as it is drawn, filled tick by tick;
//! * [`keeper`]: the same of a run of any length, in memory of a fixed size;
//! * [`stops`]: fewer ticks, with covariances and scans;
//! * [`sensed`]: what the small sensors read;
//! * [`beliefs`]: what filters held possible, at some ticks;
//! * [`score()`]: one [`Score`](rusty_contract::score::Score) per estimator of a trace;
//! * [`bands`]: what a covariance promises;
//! * [`picture`]: the run on one page, as SVG; its parts are `map`, `chart` and
//!   `panel` on a common `timeline`, its tools those of [`rusty_plot`], which also
//!   makes pixels of it.
//!
//! Nothing here reads a clock or a file: the same trace gives the same bytes.

pub mod bands;
pub(crate) mod bars;
pub mod beliefs;
pub(crate) mod chart;
pub mod keeper;
pub(crate) mod key;
pub(crate) mod map;
mod panel;
pub mod picture;
mod scored;
pub mod sensed;
pub mod stops;
pub(crate) mod timeline;
pub mod trace;

pub use beliefs::{BeliefKeeper, BeliefMoment};
pub use keeper::TraceKeeper;
pub use picture::svg;
pub use scored::{score, scores};
pub use trace::RunTrace;
