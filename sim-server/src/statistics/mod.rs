//! What many runs say together: means and their errors, quantiles, lines.
//!
//! In reading order:
//!
//! * [`moments`]: mean, standard deviation, standard error, percentiles;
//! * [`student`]: Student's t, for intervals around means of few runs;
//! * [`power_law`]: the exponent of something that grows.
//!
//! All of it is portable arithmetic: the same numbers on every machine.

pub mod moments;
pub mod power_law;
pub mod student;

pub use moments::{Moments, percentile};
pub use power_law::PowerLaw;
