//! The programs of this package.

mod drive;
mod view;

use rusty_contract::Program;

/// The programs of this package.
pub const PROGRAMS: &[Program] = &[
    Program::new("view", "shows a run or a log in a browser", view::main),
    Program::new("drive", "drives the robot by keys, in a page or a terminal", drive::main),
];
