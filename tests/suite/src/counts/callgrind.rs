//! Counting with valgrind's callgrind.

use std::path::Path;
use std::process::{Command, Stdio};

/// Whether `valgrind` can be started here.
pub fn is_there() -> bool {
    let mut command = Command::new("valgrind");
    command.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

/// Instructions that `program --run NAME` executes inside the function `name`
/// and whatever it calls.
///
/// # Errors
/// Why there is no number, in words.
pub fn count(program: &Path, name: &str) -> Result<u64, String> {
    let folder = tempfile::tempdir().map_err(|e| format!("no temporary folder: {e}"))?;
    let out = folder.path().join("counts");
    let ran = Command::new("valgrind")
        .args(["--tool=callgrind", "--collect-atstart=no"])
        .arg(format!("--toggle-collect=*{name}*"))
        .arg(format!("--callgrind-out-file={}", out.display()))
        .arg(program)
        .args(["--run", name])
        // Or the first call of a library's function would count its search.
        .env("LD_BIND_NOW", "1")
        .output()
        .map_err(|e| format!("valgrind cannot be started: {e}"))?;
    let said = String::from_utf8_lossy(&ran.stderr);
    if !ran.status.success() {
        return Err(format!("valgrind ended with {}:\n{said}", ran.status));
    }
    let text = std::fs::read_to_string(&out).map_err(|e| format!("{}: {e}\n{said}", out.display()));
    total(&text?).ok_or_else(|| format!("nothing was counted inside {name}:\n{said}"))
}

/// The number on the line `totals:` of callgrind's output; `None` if there is
/// none, or it is 0: then the function was not found.
fn total(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("totals:"))?;
    line.trim().parse().ok().filter(|count| *count > 0)
}

#[cfg(test)]
mod tests {
    use super::total;

    #[test]
    fn the_total_is_read_and_nothing_is_no_total() {
        assert_eq!(total("events: Ir\nfn=(1) step\n7 5\n\ntotals: 12345\n"), Some(12_345));
        assert_eq!(total("summary: 3\ntotals: 0\n"), None);
        assert_eq!(total(""), None);
    }
}
