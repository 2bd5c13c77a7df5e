//! Writing results to stdout and diagnostics to stderr: the same for the server
//! and all clients.
//!
//! `println!` and `eprintln!` panic when the reader has gone (`sim-server info
//! … | head`) or the disk is full. Neither is a reason to end a run. A result that
//! could not be written makes the exit code an error at the end; a reader that has
//! gone does not.
//!
//! Texts of logs and of participants' output may contain escape sequences, which
//! a terminal obeys. Everything printed here has them made visible.
//!
//! [`create`] and [`replace`](crate::replace) are for files whose names the program chooses: a named
//! pipe that has such a name would make the program wait for a reader for ever.

use std::borrow::Cow;
use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};
use std::path::Path;
use std::sync::OnceLock;

use crate::Exit;

/// Why the first write to stdout that failed did so.
static FAILED: OnceLock<io::Error> = OnceLock::new();

/// Like `println!`, but a failed write is kept for [`finish`](crate::output::finish)
/// and does not panic.
#[macro_export]
macro_rules! outln {
    () => { $crate::output::print(format_args!("")) };
    ($($arg:tt)*) => { $crate::output::print(format_args!($($arg)*)) };
}

/// Like `eprintln!`, but an stderr that cannot be written is no reason to panic.
#[macro_export]
macro_rules! errln {
    ($($arg:tt)*) => { $crate::output::report(format_args!($($arg)*)) };
}

/// Prints a line on stdout.
pub fn print(text: fmt::Arguments<'_>) {
    keep(writeln!(io::stdout(), "{}", visible(&text.to_string())));
}

/// Prints a line on stderr.
pub fn report(text: fmt::Arguments<'_>) {
    let _ = writeln!(io::stderr(), "{}", visible(&text.to_string()));
}

fn keep(written: io::Result<()>) {
    if let Err(e) = written {
        FAILED.get_or_init(|| e);
    }
}

/// Returns whether every line that was printed on stdout could be written. After
/// that, more lines are of no use.
#[must_use]
pub fn is_open() -> bool {
    FAILED.get().is_none()
}

/// Returns the exit code of `program`: the given one, or that of a failure where
/// it is 0 and results could not be written.
#[must_use]
pub fn finish(program: &str, exit: Exit) -> Exit {
    keep(io::stdout().flush());
    let failed = FAILED.get().filter(|e| e.kind() != io::ErrorKind::BrokenPipe);
    let Some(error) = failed else { return exit };
    errln!(
        "{program}: writing the results to stdout failed: {error}; repeat it with a stdout that \
         can be written"
    );
    if exit == Exit::Done { Exit::Failed } else { exit }
}

/// Returns whether both paths lead to one file.
#[must_use]
pub fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// Creates a file, or empties it; does not wait for a pipe's reader. Devices are
/// written to.
///
/// # Errors
/// What the operating system reports, or that this is a pipe or a socket.
pub fn create(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.write(true).create(true).truncate(true);
    #[cfg(unix)]
    {
        use std::os::unix::fs::{FileTypeExt as _, OpenOptionsExt as _};
        if std::fs::metadata(path)
            .is_ok_and(|m| m.file_type().is_fifo() || m.file_type().is_socket())
        {
            let problem = "expected a regular file, got a pipe or a socket; remove it, or choose \
                           another folder";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
        }
        // A pipe that comes between these two steps does not hold anybody, either.
        options.custom_flags(rustix::fs::OFlags::NONBLOCK.bits().cast_signed());
    }
    options.open(path).map_err(|e| {
        let remedy = match e.kind() {
            io::ErrorKind::NotFound => "make its folder first, or give another path",
            _ => "give another path",
        };
        explained(&e, "cannot be written", remedy)
    })
}

/// Makes a folder, and those above it.
///
/// # Errors
/// What the operating system reports, with the remedy.
pub fn make_folder(path: &Path) -> io::Result<()> {
    let refused = |e| explained(&e, "the folder cannot be made", "give another one");
    std::fs::create_dir_all(path).map_err(refused)
}

fn explained(error: &io::Error, problem: &str, remedy: &str) -> io::Error {
    io::Error::new(error.kind(), format!("{problem}: {error}; {remedy}"))
}

/// The text with its control characters and the invisible characters that change
/// the order of a line written as `\u001b`, as in JSON; line breaks and tabs stay.
#[must_use]
pub fn visible(text: &str) -> Cow<'_, str> {
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
