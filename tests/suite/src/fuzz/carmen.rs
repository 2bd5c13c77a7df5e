//! A CARMEN log of a real robot, plain or gzip, and the run log made from it.

use rusty_logs::import::{ImportOptions, import_carmen};

use super::imported::{check, place};

/// Words of the format.
pub const WORDS: [&str; 14] = [
    "ODOM ",
    "FLASER 3 ",
    "RLASER ",
    "PARAM robot_frontlaser_offset 0.1\n",
    "\n",
    "# ",
    "nan",
    "PARAM robot_front_laser_max 1e999\n",
    "inf",
    "-inf",
    "1e999",
    "-1",
    " nohost ",
    "\u{1f}\u{8b}",
];

/// Imports the recording and reads the run log.
pub fn carmen(bytes: &[u8]) -> bool {
    let [input, output] = ["in.log", "out.log"].map(place);
    std::fs::write(&input, bytes).expect("a file can be written");
    let mut lines = 0;
    let options = ImportOptions { writer: "fuzz", strict: false };
    let Ok(report) = import_carmen(&input, &output, options, &mut |done| lines = done) else {
        return false;
    };
    check(&report, &output, lines);
    true
}
