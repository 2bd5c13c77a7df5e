//! Which of two estimators is better, by how much, and how sure that is: from
//! the rows of sweeps, on the same seeds.
//!
//! In reading order:
//!
//! * [`metric`]: what is compared;
//! * [`contents`]: the runs in a table, and what was set in them;
//! * [`side`]: A and B, and whether they drove the same runs;
//! * [`contest`]: pairs, and what they say, metric by metric;
//! * [`report`]: the same in words;
//! * [`drawing`]: the same in pictures;
//! * [`error`].

pub mod contents;
pub mod contest;
pub mod drawing;
pub mod error;
pub mod metric;
pub mod report;
pub mod side;
#[cfg(test)]
mod tests;

pub use contents::Contents;
pub use contest::Versus;
pub use error::VersusError;
pub use metric::Metric;
pub use side::{Side, sides};
