//! `Replacement`: a file that is complete or not there.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::output::create;

/// A file while it is written next to its place, under a hidden name. It comes to
/// its place with [`Replacement::commit`]; without, it is removed. A link stays, and its
/// file is replaced. A device is written to.
#[derive(Debug)]
pub struct Replacement {
    file: File,
    /// The hidden name; `None` for a device.
    partial: Option<PathBuf>,
}

impl Replacement {
    /// Begins a file for `path`.
    ///
    /// # Errors
    /// What the operating system reports, or that the path names no file: `-` does not,
    /// which many programs take for standard output.
    pub fn of(path: &Path) -> io::Result<Self> {
        if path.as_os_str() == "-" {
            let text = "expected a file, got - (standard output); give a path, ./- for this name";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, text));
        }
        let path = &followed(path);
        let name = path.file_name().ok_or_else(|| io::Error::other("the path names no file"))?;
        if path.metadata().is_ok_and(|found| !found.is_file()) {
            return Ok(Self { file: create(path)?, partial: None });
        }
        let mut hidden = OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}.partial", std::process::id()));
        // On the same disk, or it could not be renamed.
        let partial = path.with_file_name(hidden);
        Ok(Self { file: create(&partial)?, partial: Some(partial) })
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
        let Some(partial) = &self.partial else { return Ok(()) };
        self.file.sync_all()?;
        fs::rename(partial, followed(path))
    }

    /// As [`Replacement::commit`], if there is no such file.
    ///
    /// # Errors
    /// What the operating system reports, or that there is one by now.
    pub fn commit_new(self, path: &Path) -> io::Result<()> {
        let Some(partial) = &self.partial else { return Ok(()) };
        self.file.sync_all()?;
        match fs::hard_link(partial, path) {
            // A disk without links of this kind.
            Err(_) if !path.exists() => fs::rename(partial, path),
            linked => linked,
        }
    }
}

/// The file of a link, or the path.
fn followed(path: &Path) -> PathBuf {
    let file = path.is_symlink().then(|| path.canonicalize().ok()).flatten();
    file.unwrap_or_else(|| path.to_owned())
}

impl Write for Replacement {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Replacement {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

impl Drop for Replacement {
    fn drop(&mut self) {
        if let Some(partial) = &self.partial {
            // Already renamed, or nothing is left to do about it.
            let _ = fs::remove_file(partial);
        }
    }
}

/// Writes a whole file, or none; a device is written to.
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
        let hidden =
            partial.partial.as_ref().unwrap().file_name().unwrap().to_str().unwrap().to_owned();
        assert_eq!(Replacement::target_of(&hidden), Some("file"));
        drop(partial);
        for other in ["file", ".file.partial", ".file.x.partial", ".file.7"] {
            assert_eq!(Replacement::target_of(other), None, "{other}");
        }
        assert_eq!(fs::read(&path).unwrap(), b"one");
        replace(&path, b"three").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"three");
        assert!(replace(&folder.path().join("none/file"), b"").is_err());
        assert_eq!(replace(Path::new("-"), b"").unwrap_err().kind(), io::ErrorKind::InvalidInput);
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "something is left");
    }

    #[test]
    #[cfg(unix)]
    fn a_pipe_in_the_place_of_a_file_is_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
        rustix::fs::mkfifoat(rustix::fs::CWD, at("pipe"), mode).unwrap();
        std::os::unix::fs::symlink(at("pipe"), at("link")).unwrap();
        for name in ["pipe", "link"] {
            assert_eq!(replace(&at(name), b"x").unwrap_err().kind(), io::ErrorKind::InvalidInput);
        }
        std::os::unix::fs::symlink(at("file"), at("to-file")).unwrap();
        for (name, text) in [("file", "longer"), ("to-file", "text")] {
            replace(&at(name), text.as_bytes()).unwrap();
        }
        assert_eq!(fs::read(at("file")).unwrap(), b"text");
        assert!(at("to-file").is_symlink());
        replace(Path::new("/dev/null"), b"x").unwrap();
        std::os::unix::fs::symlink("/dev/null", at("to-device")).unwrap();
        replace(&at("to-device"), b"x").unwrap();
        assert!(!at("to-device").metadata().unwrap().is_file());
        // Not at the end of the work, but before it.
        assert!(Replacement::of(folder.path()).is_err());
    }

    #[test]
    fn a_new_file_takes_no_other_s_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        Replacement::of(&path).unwrap().commit_new(&path).unwrap();
        fs::write(&path, b"one").unwrap();
        let second = Replacement::of(&path).unwrap().commit_new(&path).unwrap_err();
        assert_eq!(second.kind(), io::ErrorKind::AlreadyExists);
        assert_eq!(fs::read(&path).unwrap(), b"one");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "something is left");
    }
}
