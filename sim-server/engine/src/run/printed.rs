//! Excerpts of a participant's output, for messages about its end.

use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;

/// The part of the output that is searched, from its end, bytes.
const SEARCHED: u64 = 1 << 20;
/// Lines shown from the end.
const LAST_LINES: usize = 3;
/// Characters shown of a line.
const LINE_CHARS: usize = 300;
/// A line that has one of these, in lower case, reports an error.
const ERROR_MARKS: [&str; 5] =
    ["error:", "panicked at", "traceback (most recent", "error while loading", "fatal"];

/// Returns the first line that reports an error and the last three lines, each
/// indented on a line; `None` if nothing was printed.
pub(super) fn excerpt(path: &Path) -> Option<String> {
    let mut file = rusty_contract::input::open(path).ok()?;
    let length = file.metadata().ok()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(SEARCHED))).ok()?;
    let mut text = Vec::new();
    file.take(SEARCHED).read_to_end(&mut text).ok()?;
    shown(&String::from_utf8_lossy(&text))
}

fn shown(text: &str) -> Option<String> {
    let lines: Vec<&str> = text.lines().map(str::trim_end).filter(|l| !l.is_empty()).collect();
    let first_shown = lines.len().saturating_sub(LAST_LINES);
    let mut shown = Vec::new();
    if let Some(error) = lines[..first_shown].iter().position(|line| is_error(line)) {
        shown.push(lines[error]);
        if error + 1 < first_shown {
            shown.push("...");
        }
    }
    shown.extend(&lines[first_shown..]);
    let indented = shown.iter().map(|line| {
        let line: String = line.chars().take(LINE_CHARS).collect();
        format!("\n    {line}")
    });
    (!shown.is_empty()).then(|| indented.collect())
}

fn is_error(line: &str) -> bool {
    let line = line.to_lowercase();
    ERROR_MARKS.iter().any(|mark| line.contains(mark))
}

/// Whether there is anything in this file.
pub fn has_content(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|m| m.len() > 0)
}

/// Whether the disk that holds this file has no room for a message.
pub(super) fn is_full(path: &Path) -> bool {
    const MESSAGE: u64 = 4096;
    rustix::fs::statvfs(path)
        .is_ok_and(|disk| disk.f_bavail.saturating_mul(disk.f_frsize) < MESSAGE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_error_and_the_last_lines_are_shown() {
        let panic = "ready\nthread 'main' panicked at src/main.rs:3:5:\nindex out of bounds\n\
                     stack backtrace:\n   0: a\n   1: b\n   2: c\n\n";
        let lines = |text| shown(text).map(|s| s.lines().map(|l| l.trim().to_owned()).collect());
        let expected = ["", "thread 'main' panicked at src/main.rs:3:5:", "...", "0: a", "1: b"];
        let expected: Vec<String> =
            expected.into_iter().chain(["2: c"]).map(str::to_owned).collect();
        assert_eq!(lines(panic), Some(expected));
        let short: Vec<String> = ["", "error: no", "try --help"].map(str::to_owned).to_vec();
        assert_eq!(lines("error: no\n\n  try --help\n"), Some(short));
        assert_eq!(shown(" \n\n"), None);
        let long = shown(&"x".repeat(10_000)).unwrap();
        assert!(long.len() < 400, "{}", long.len());
    }
}
