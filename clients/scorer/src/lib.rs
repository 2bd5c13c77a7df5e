//! The scorer, and what it computes and draws.
//!
//! * [`scorer`]: the participant;
//! * [`scoring`]: what is kept of a run, its figures and its pictures;
//! * [`report`]: the page.

pub mod report;
pub mod scorer;
pub mod scoring;
