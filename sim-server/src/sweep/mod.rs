//! Many runs: every seed in every cell of a grid of settings.
//!
//! In reading order:
//!
//! * [`cell`]: a setting of the swept fields, and what a sweep comes to;
//! * [`row`]: the figures of one estimator in one run;
//! * [`track`]: where it was on the way.

pub mod cell;
pub mod row;
pub mod track;

pub use cell::{Cell, Swept};
pub use row::Row;
pub use track::{Sample, Track};
