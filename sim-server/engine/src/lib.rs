//! The engine: when the next tick may happen, and what is in it.
//!
//! In reading order:
//!
//! * [`lockstep`]: the protocol, a state machine without I/O;
//! * [`run`]: a run, from the first join to the last answer;
//! * [`source`]: where frames come from;
//! * [`executable`]: the program of a participant, which this binary may contain;
//! * [`confine`]: the kernel gate, for participants with a sandbox;
//! * [`scenario_file`]: scenarios, built in or in files; [`remarks`]: what is odd in one;
//! * [`mod@shell`]: commands in words.
//!
//! It knows the world, the transport and the contract. Command line, tables and
//! drawings are in the crates that use it.

pub mod confine;
pub mod executable;
pub mod lockstep;
pub mod remarks;
pub mod run;
pub mod scenario_file;
pub mod shell;
pub mod source;
