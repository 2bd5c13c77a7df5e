//! Work on finished logs.
//!
//! * [`import`]: recordings of real robots;
//! * [`drivers`]: commands of other robots' drivers;
//! * [`export`]: logs for other programs;
//! * [`replay`]: the frames of a log for another run;
//! * [`fork`]: runs that leave a log's run in the middle;
//! * [`compare`], [`comparison`], [`original`]: their differences, bit by bit;
//! * [`seal`]: logs without their truth, to hand out;
//! * [`folder`]: folders of runs, one run each.

pub mod compare;
pub mod comparison;
pub mod drivers;
pub mod export;
pub mod folder;
pub mod fork;
pub mod import;
pub mod original;
pub mod replay;
pub mod seal;
