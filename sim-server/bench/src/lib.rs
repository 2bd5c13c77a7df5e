//! Speed, measured: each bench in a separate file or folder, and what all of
//! them share.
//!
//! * [`machine`]: on what it was measured;
//! * [`noise`]: how much the machine was disturbed meanwhile;
//! * [`quantiles`]: what a list of durations comes to;
//! * [`usage`]: what a process has used of the machine;
//! * [`stage`], [`stamps`]: repetitions with real processes, and their clock;
//! * [`results`]: rows of figures, as tables and as JSON;
//! * [`report`]: the document that every bench prints;
//! * [`alternate`]: several ways to do something, timed in turns;
//! * [`page`]: all of them on a page.
//!
//! The benches: [`latency`], a tick; [`scan`], a beam; [`step`], the parts of a
//! tick; [`mod@log`], a record; [`sweep`], many runs; [`idle`], waiting; [`start`], a launch.
//!
//! A bench never decides what is fast: it measures next to something else in the
//! same run and prints the ratio. Times are read from the monotonic clock and
//! reach no digest.

pub mod alternate;
mod error;
pub mod idle;
pub mod latency;
pub mod log;
pub mod machine;
pub mod noise;
#[cfg(feature = "sweep")]
pub mod page;
pub mod quantiles;
pub mod report;
pub mod results;
pub mod scan;
pub mod stage;
pub mod stamps;
pub mod start;
pub mod step;
#[cfg(feature = "sweep")]
pub mod sweep;
pub mod usage;

pub use error::BenchError;
