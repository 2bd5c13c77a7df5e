//! Writing results to stdout.
//!
//! `println!` panics when the reader has gone (`sim-server info … | head`).
//! A reader that has seen enough is no failure, so these writes may fall on
//! deaf ears; the exit code still says how the verb ended.

/// Like `println!`, but a closed stdout is no reason to panic.
macro_rules! outln {
    ($($arg:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($arg)*);
    }};
}
pub(crate) use outln;
