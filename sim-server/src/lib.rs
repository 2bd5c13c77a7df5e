//! The process that owns time.
//!
//! In reading order:
//!
//! * [`cli`]: the command line;
//! * [`verbs`]: what it can do, a file each;
//! * [`lockstep`]: the protocol, a state machine without I/O;
//! * [`run`]: a run, from the first join to the last goodbye;
//! * [`confine`]: the kernel gate, for participants with a sandbox;
//! * [`folder`]: folders of runs, one run each;
//! * [`source`]: where frames come from, the world or a log;
//! * [`scenario_file`]: scenarios, built in or in files;
//! * [`compare`]: two ticks, or documents, field by field;
//! * [`conformance`]: what a client gets right of the protocol;
//! * [`import`]: recordings of real robots;
//! * [`statistics`]: what many runs say together;
//! * [`sweep`]: many runs, a row each;
//! * [`versus`]: which of two estimators is better, from a sweep's rows;
//! * [`budget`]: how much of the odometry's error comes from where;
//! * [`umbmark`]: the square of Borenstein and Feng, both ways round;
//! * [`export`]: logs for other programs;
//! * [`seal`]: logs without their truth, to hand out;
//! * [`mod@bench`]: speed, measured beside what it is to be compared with;
//! * [`report`]: what a run came to;
//! * [`bits`], [`error`].

pub mod bench;
pub mod bits;
pub mod budget;
pub mod cli;
pub mod compare;
pub mod confine;
pub mod conformance;
pub mod error;
pub mod export;
pub mod folder;
pub mod import;
pub mod lockstep;
pub mod report;
pub mod run;
pub mod scenario_file;
pub mod seal;
pub mod source;
pub mod statistics;
pub mod sweep;
pub mod umbmark;
pub mod verbs;
pub mod versus;
