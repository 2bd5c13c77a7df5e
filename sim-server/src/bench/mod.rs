//! Speed, measured: each bench in a file or room of its own, and what all of
//! them share.
//!
//! * [`machine`]: on what it was measured;
//! * [`noise`]: how much the machine was disturbed meanwhile;
//! * [`quantiles`]: what a list of durations comes to;
//! * [`usage`]: what a process has used of the machine;
//! * [`stage`], [`stamps`]: repetitions with real processes, and their clock;
//! * [`report`]: the document that every bench prints.
//!
//! The benches: [`latency`], [`idle`], [`start`], [`mod@log`].
//!
//! A bench never decides what is fast: it measures beside something else in the
//! same run and prints the ratio. Times are read from the monotonic clock and
//! reach no digest.

pub mod idle;
pub mod latency;
pub mod log;
pub mod machine;
pub mod noise;
pub mod quantiles;
pub mod report;
pub mod stage;
pub mod stamps;
pub mod start;
pub mod usage;
