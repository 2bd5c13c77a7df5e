//! Results to stdout, talk to stderr. A reader that has gone is no reason to
//! panic.

use std::fmt::Display;
use std::io::Write as _;

/// A line of a result.
pub fn print(line: impl Display) {
    let _ = writeln!(std::io::stdout(), "{line}");
}

pub fn say(line: impl Display) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
