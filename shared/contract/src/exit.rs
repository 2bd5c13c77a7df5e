//! The exit codes that every program here shares.

use std::process::{ExitCode, Termination};

/// How a program ended. The numbers are part of the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// Everything asked for was done.
    Done = 0,
    /// It failed; the message says where and what helps.
    Failed = 1,
    /// The command line was wrong (clap's own code).
    Usage = 2,
    /// It finished, but a participant or data was lost.
    Lost = 3,
    /// Two things that must be equal bit for bit are not.
    NotBitExact = 4,
}

impl Termination for Exit {
    fn report(self) -> ExitCode {
        ExitCode::from(self as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_are_the_documented_ones() {
        let codes = [Exit::Done, Exit::Failed, Exit::Usage, Exit::Lost, Exit::NotBitExact];
        assert_eq!(codes.map(|c| c as u8), [0, 1, 2, 3, 4]);
    }
}
