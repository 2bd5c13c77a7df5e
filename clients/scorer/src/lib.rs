//! The scorer, and what it computes and draws.
//!
//! * [`scorer`]: the participant;
//! * [`scoring`]: what is kept of a run, its figures and its pictures;
//! * [`report`]: the page.

mod programs;
pub mod report;
pub mod scorer;
pub mod scoring;

pub use programs::PROGRAMS;
