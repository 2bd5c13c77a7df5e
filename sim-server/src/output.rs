//! Writing results to stdout and talk to stderr.
//!
//! `println!` and `eprintln!` panic when the reader has gone (`sim-server info
//! … | head`) or the disk is full. Neither is a reason to end a run, so these
//! writes may fall on deaf ears; the exit code still says how the verb ended.

/// Like `println!`, but a closed stdout is no reason to panic.
macro_rules! outln {
    ($($arg:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($arg)*);
    }};
}
pub(crate) use outln;

/// Like `eprintln!`, but an stderr that cannot be written is no reason to panic.
macro_rules! errln {
    ($($arg:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($arg)*);
    }};
}
pub(crate) use errln;
