//! Opening input files: regular files only.
//!
//! A named pipe makes its reader wait for a writer, for ever if none comes, and a
//! device such as `/dev/zero` has no end.

use std::fs::{File, OpenOptions};
use std::io;
use std::path::Path;

/// Opens a regular file for reading; does not wait for a pipe's writer.
///
/// # Errors
/// What the operating system reports, or that this is a pipe or a device.
pub fn open(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt as _;
        // A named pipe is opened at once, to be refused below. Regular files are
        // read as without the flag.
        options.custom_flags(rustix::fs::OFlags::NONBLOCK.bits().cast_signed());
    }
    let file = options.open(path)?;
    let kind = file.metadata()?.file_type();
    // Reading a folder is an error of the operating system, which names it.
    if !kind.is_file() && !kind.is_dir() {
        let problem = "expected a regular file, got a pipe or a device; save its contents in a \
                       file and give that";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
    }
    Ok(file)
}

/// What some editors put before text in UTF-8.
pub const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();

/// Reads a whole regular file.
///
/// # Errors
/// Those of [`open`], and of reading.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    io::Read::read_to_end(&mut open(path)?, &mut bytes)?;
    Ok(bytes)
}

/// Reads a whole regular file of at most `max_bytes` bytes.
///
/// # Errors
/// Those of [`open`], and of reading; a longer file is an error.
pub fn read_at_most(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    io::Read::read_to_end(&mut io::Read::take(open(path)?, max_bytes + 1), &mut bytes)?;
    if bytes.len() as u64 > max_bytes {
        let problem = format!("longer than {max_bytes} bytes; is this the right file?");
        return Err(io::Error::other(problem));
    }
    Ok(bytes)
}

/// Reads a whole text file of at most `max_bytes` bytes, without a byte order mark.
///
/// # Errors
/// Those of [`read_at_most`]; text that is not UTF-8 is an error.
pub fn read_text_at_most(path: &Path, max_bytes: u64) -> io::Result<String> {
    let mut bytes = read_at_most(path, max_bytes)?;
    if bytes.starts_with(BYTE_ORDER_MARK) {
        bytes.drain(..BYTE_ORDER_MARK.len());
    }
    let text = String::from_utf8(bytes);
    text.map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error.utf8_error()))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_are_read_and_a_pipe_does_not_wait() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("file"), "text").unwrap();
        std::os::unix::fs::symlink(at("file"), at("link")).unwrap();
        assert_eq!(read(&at("file")).unwrap(), b"text");
        assert_eq!(read(&at("link")).unwrap(), b"text");

        let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
        rustix::fs::mkfifoat(rustix::fs::CWD, at("pipe"), mode).unwrap();
        std::os::unix::fs::symlink(at("pipe"), at("to-pipe")).unwrap();
        for refused in [at("pipe"), at("to-pipe"), "/dev/zero".into()] {
            let kind = open(&refused).unwrap_err().kind();
            assert_eq!(kind, io::ErrorKind::InvalidInput, "{}", refused.display());
        }
        assert_eq!(read(folder.path()).unwrap_err().kind(), io::ErrorKind::IsADirectory);
        assert_eq!(open(&at("absent")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }
}
