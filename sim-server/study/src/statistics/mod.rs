//! What many runs say together: means and their errors, quantiles, lines.
//!
//! In reading order:
//!
//! * [`moments`]: mean, standard deviation, standard error, percentiles;
//! * [`student`]: Student's t, for intervals around means of few runs;
//! * [`sign_test`], [`pairs`]: two figures on the same seeds;
//! * [`mean_of_squares`]: where the mean of normalised squared errors should lie;
//! * [`power_law`]: the exponent of something that grows.
//!
//! All of it is portable arithmetic: the same numbers on every machine.

pub mod mean_of_squares;
pub mod moments;
pub mod pairs;
pub mod power_law;
pub mod sign_test;
pub mod student;

pub use moments::{Moments, percentile};
pub use pairs::Pairs;
pub use power_law::PowerLaw;
pub use sign_test::SignTest;
