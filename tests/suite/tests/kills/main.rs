//! `kill -9` of everyone, at random and at exact moments. The run ends or goes
//! on as its scenario says; a process that was killed is named, as dead; the others
//! end by themselves; the log reads up to where it goes; nothing is left.
//!
//! Answers may take longer than a case may: that a process died must come from
//! the kernel, or the case fails.
//!
//! `RUSTY_KILLS=1500 cargo test --test kills` makes more of them. A case that
//! fails says how to repeat it alone.

mod exact;
mod random;

use random::series;

#[test]
fn a_server_killed_at_any_moment() {
    series("sim-server");
}

#[test]
fn a_driver_killed_at_any_moment() {
    series("wander");
}

#[test]
fn an_estimator_killed_at_any_moment() {
    series("estimator");
}

#[test]
fn a_scorer_killed_at_any_moment() {
    series("score");
}

#[test]
fn a_logger_killed_at_any_moment() {
    series("logger");
}
