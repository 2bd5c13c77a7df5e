//! Instruction counts: how much work the core does, the same on every run.
//!
//! Times differ from machine to machine and from minute to minute; the number of
//! instructions between two points of a program does not. `valgrind` counts
//! those inside the functions of [`work`], and [`budget`] compares them with
//! what was agreed on, so that nothing becomes slower unnoticed.
//!
//! * [`work`] is what is counted;
//! * [`callgrind`] is how;
//! * [`budget`] is what it may come to.

pub mod budget;
pub mod callgrind;
pub mod work;
