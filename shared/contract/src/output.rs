//! Writing results to stdout and diagnostics to stderr.
//!
//! `println!` and `eprintln!` panic when the reader has gone (`sim-server info
//! … | head`) or the disk is full. Neither is a reason to end a run. A result that
//! could not be written makes the exit code an error at the end; a reader that has
//! gone does not.
//!
//! Texts of logs and of participants' output may contain escape sequences, which
//! a terminal obeys. Everything printed here has them made visible.

use std::borrow::Cow;
use std::fmt;
use std::io::{self, Write as _};
use std::sync::OnceLock;

use rusty_contract::Exit;

/// Why the first write to stdout that failed did so.
static FAILED: OnceLock<String> = OnceLock::new();

/// Like `println!`, but a failed write is kept for [`finish`] and does not panic.
macro_rules! outln {
    () => { $crate::output::print(format_args!("")) };
    ($($arg:tt)*) => { $crate::output::print(format_args!($($arg)*)) };
}
pub(crate) use outln;

/// Like `eprintln!`, but an stderr that cannot be written is no reason to panic.
macro_rules! errln {
    ($($arg:tt)*) => { $crate::output::report(format_args!($($arg)*)) };
}
pub(crate) use errln;

/// Prints a line on stdout.
pub(crate) fn print(text: fmt::Arguments<'_>) {
    keep(writeln!(io::stdout(), "{}", visible(&text.to_string())));
}

/// Prints a line on stderr.
pub(crate) fn report(text: fmt::Arguments<'_>) {
    let _ = writeln!(io::stderr(), "{}", visible(&text.to_string()));
}

fn keep(written: io::Result<()>) {
    if let Err(e) = written
        && e.kind() != io::ErrorKind::BrokenPipe
    {
        FAILED.get_or_init(|| e.to_string());
    }
}

/// Returns the exit code of the program: that of the verb, or of a failure where
/// the verb succeeded and its results could not be written.
pub(crate) fn finish(exit: Exit) -> Exit {
    keep(io::stdout().flush());
    let Some(error) = FAILED.get() else { return exit };
    errln!(
        "sim-server: writing the results to stdout failed: {error}; repeat it with a stdout that \
         can be written"
    );
    if exit == Exit::Done { Exit::Failed } else { exit }
}

/// The text with its control characters and the invisible characters that change
/// the order of a line written as `\u001b`, as in JSON; line breaks and tabs stay.
pub(crate) fn visible(text: &str) -> Cow<'_, str> {
    let hidden = |c: char| match c {
        '\n' | '\t' => false,
        '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{2069}' => true,
        '\u{feff}' => true,
        _ => c.is_control(),
    };
    if !text.contains(hidden) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if hidden(c) {
            shown.push_str(&format!("\\u{:04x}", u32::from(c)));
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_made_visible_and_json_stays_json() {
        let text = "a\x1b[2J\r\u{9b}1mb\u{202e}c\x7f\n\té";
        let shown = visible(text);
        assert_eq!(shown, "a\\u001b[2J\\u000d\\u009b1mb\\u202ec\\u007f\n\té");
        assert!(matches!(visible("plain\ntext °"), Cow::Borrowed(_)));
        let json = serde_json::to_string_pretty(&[text]).unwrap();
        let read: Vec<String> = serde_json::from_str(&visible(&json)).unwrap();
        assert_eq!(read, [text]);
    }
}
