//! Many runs: every seed in every cell of a grid of settings.
//!
//! In reading order:
//!
//! * [`seeds`]: which seeds;
//! * [`cell`]: a setting of the swept fields, and what a sweep comes to;
//! * [`row`]: the figures of one estimator in one run;
//! * [`track`]: where it was on the way;
//! * [`mod@summary`], [`mod@growth`], [`paired`]: what the rows and tracks say: means,
//!   spreads over distance ([`growth_text`] for people), differences on the same seeds;
//! * [`drawing`]: the fan and the growth, drawn.

pub mod cell;
pub mod drawing;
#[cfg(test)]
mod fixtures;
pub mod growth;
pub mod growth_text;
pub mod paired;
pub mod row;
pub mod seeds;
pub mod summary;
pub mod track;

pub use cell::{Cell, Swept};
pub use growth::growth;
pub use growth_text::GrowthText;
pub use paired::ab;
pub use row::Row;
pub use seeds::Seeds;
pub use summary::{Summary, summary};
pub use track::{Sample, Track};
