//! The process that owns time.
//!
//! In reading order:
//!
//! * [`cli`]: the command line;
//! * [`verbs`]: what it can do, a file each;
//! * [`lockstep`]: the protocol, a state machine without I/O;
//! * [`run`]: a run, from the first join to the last goodbye;
//! * [`confine`]: the kernel gate, for participants with a sandbox;
//! * [`source`]: where frames come from, the world or a log;
//! * [`scenario_file`]: scenarios, built in or in files;
//! * [`compare`]: two ticks, field by field, bit by bit;
//! * [`conformance`]: what a client gets right of the protocol;
//! * [`import`]: recordings of real robots;
//! * [`seal`]: logs without their truth, to hand out;
//! * [`mod@bench`]: speed, measured beside what it is to be compared with;
//! * [`report`]: what a run came to;
//! * [`bits`], [`error`].

pub mod bench;
pub mod bits;
pub mod cli;
pub mod compare;
pub mod confine;
pub mod conformance;
pub mod error;
pub mod import;
pub mod lockstep;
mod output;
pub mod report;
pub mod run;
pub mod scenario_file;
pub mod seal;
pub mod source;
pub mod verbs;
