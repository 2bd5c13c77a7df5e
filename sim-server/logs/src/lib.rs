//! Work on finished logs.
//!
//! * [`import`]: recordings of real robots;
//! * [`export`]: logs for other programs;
//! * [`seal`]: logs without their truth, to hand out;
//! * [`folder`]: folders of runs, one run each.

pub mod export;
pub mod folder;
pub mod import;
pub mod seal;
