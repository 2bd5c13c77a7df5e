//! The programs of this package.

mod belief;
mod score;

use rusty_contract::Program;

/// The programs of this package.
pub const PROGRAMS: &[Program] = &[
    Program::new("score", "compares estimates with the truth, writes the report", score::main),
    Program::new("belief", "shows the beliefs of filters during a run", belief::main),
];
