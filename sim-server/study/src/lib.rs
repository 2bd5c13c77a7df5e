//! Many runs, and what they show together.
//!
//! * [`sweep`]: many runs, a row each;
//! * [`versus`]: which of two estimators is better, from a sweep's rows;
//! * [`benchmark`]: a fixed suite, with results that others can check;
//! * [`budget`]: odometry error by source;
//! * [`umbmark`]: the square of Borenstein and Feng, in both directions;
//! * [`documents`]: the fields in which two JSON documents differ.

pub mod benchmark;
pub mod budget;
pub mod documents;
mod page;
pub mod sweep;
pub mod umbmark;
pub mod versus;
