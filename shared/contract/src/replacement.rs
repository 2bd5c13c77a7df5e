//! `Replacement`: a file that is complete or not there.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A file while it is written next to its place, under a hidden name. It comes to
/// its place with [`Replacement::commit`]; without, it is removed.
#[derive(Debug)]
pub struct Replacement {
    file: File,
    partial: PathBuf,
}

impl Replacement {
    /// Begins a file for `path`.
    ///
    /// # Errors
    /// What the operating system reports, or that the path names no file.
    pub fn of(path: &Path) -> io::Result<Self> {
        let name = path.file_name().ok_or_else(|| io::Error::other("the path names no file"))?;
        let mut hidden = OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}.partial", std::process::id()));
        // On the same disk, or it could not be renamed.
        let partial = path.with_file_name(hidden);
        Ok(Self { file: File::create(&partial)?, partial })
    }

    /// Returns the name of the file that a hidden one in its folder was to become, if
    /// `name` is that of a hidden one: a process that was killed leaves it.
    #[must_use]
    pub fn target_of(name: &str) -> Option<&str> {
        let (target, process) =
            name.strip_prefix('.')?.strip_suffix(".partial")?.rsplit_once('.')?;
        process.parse::<u32>().is_ok().then_some(target)
    }

    /// Moves the file to `path` once all of it is on the disk.
    ///
    /// # Errors
    /// What the operating system reports.
    pub fn commit(self, path: &Path) -> io::Result<()> {
        self.file.sync_all()?;
        fs::rename(&self.partial, path)
    }
}

impl Write for Replacement {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for Replacement {
    fn drop(&mut self) {
        // Already renamed, or nothing is left to do about it.
        let _ = fs::remove_file(&self.partial);
    }
}

/// Writes a whole file, or none.
///
/// # Errors
/// Those of [`Replacement`], and of writing.
pub fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = Replacement::of(path)?;
    file.write_all(bytes)?;
    file.commit(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_whole_or_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        replace(&path, b"one").unwrap();
        let mut partial = Replacement::of(&path).unwrap();
        partial.write_all(b"two").unwrap();
        let hidden = partial.partial.file_name().unwrap().to_str().unwrap().to_owned();
        assert_eq!(Replacement::target_of(&hidden), Some("file"));
        drop(partial);
        for other in ["file", ".file.partial", ".file.x.partial", ".file.7"] {
            assert_eq!(Replacement::target_of(other), None, "{other}");
        }
        assert_eq!(fs::read(&path).unwrap(), b"one");
        replace(&path, b"three").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"three");
        assert!(replace(&folder.path().join("none/file"), b"").is_err());
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "something is left");
    }
}
