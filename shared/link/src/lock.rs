//! The files of a run's folder: whose they are, who holds the lock, what is in it.

use std::fs::{self, File};
use std::io::Read as _;
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _};
use std::path::Path;
use std::time::{Duration, Instant};

use rustix::fs::{FlockOperation, flock};

use crate::domain_error::{DomainError, io};
use crate::umask::with_umask;

/// Longest time in which a process looks at a lock or sweeps behind it.
pub(crate) const SWEEP_TIME: Duration = Duration::from_secs(2);

/// Makes the folder if it is not there, for this user alone.
pub(crate) fn ensure_own_folder(path: &Path) -> Result<(), DomainError> {
    let deadline = Instant::now() + SWEEP_TIME;
    loop {
        match with_umask(|| fs::DirBuilder::new().mode(0o700).create(path)) {
            Err(e) if e.kind() != std::io::ErrorKind::AlreadyExists => {
                return Err(io(path, "make the folder")(e));
            }
            _ => {}
        }
        match check_own_folder(path) {
            // Swept by another between the two steps: once more.
            Err(DomainError::Io { error, .. })
                if error.kind() == std::io::ErrorKind::NotFound && Instant::now() < deadline => {}
            checked => return checked,
        }
    }
}

/// Refuses what is no folder of this user's own: on a shared machine another user
/// else may have put a folder or a link where ours would be.
pub(crate) fn check_own_folder(path: &Path) -> Result<(), DomainError> {
    let found = fs::symlink_metadata(path).map_err(io(path, "look at the folder"))?;
    let me = rustix::process::getuid().as_raw();
    if found.uid() != me || !found.is_dir() || found.mode() & 0o022 != 0 {
        return Err(DomainError::NotYours {
            path: path.display().to_string(),
            owner: found.uid(),
            me,
        });
    }
    Ok(())
}

/// Takes the lock if it is free.
pub(crate) fn take_lock(folder: &Path) -> Result<Option<File>, DomainError> {
    let path = folder.join("lock");
    let open =
        fs::OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
    let lock = match open {
        Ok(lock) => lock,
        // The folder was swept between two steps; the caller looks again.
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            ensure_own_folder(folder)?;
            return take_lock(folder);
        }
        Err(e) => return Err(io(&path, "open the lock")(e)),
    };
    match flock(&lock, FlockOperation::NonBlockingLockExclusive) {
        Ok(()) => Ok(Some(lock)),
        Err(_) => Ok(None),
    }
}

/// Whether the locked file is still the one in the folder.
pub(crate) fn is_current(lock: &File, folder: &Path) -> bool {
    match (lock.metadata(), fs::metadata(folder.join("lock"))) {
        (Ok(held), Ok(named)) => held.ino() == named.ino() && held.dev() == named.dev(),
        _ => false,
    }
}

pub(crate) fn read_pid(folder: &Path) -> u32 {
    read_lock(folder).0
}

/// Process and nonce of the server, as the lock has them; zeros if it has none.
pub(crate) fn read_lock(folder: &Path) -> (u32, u32) {
    let mut text = String::new();
    let read = File::open(folder.join("lock")).and_then(|f| f.take(40).read_to_string(&mut text));
    let mut words = text.split_whitespace().map(|word| word.parse().unwrap_or(0));
    match read {
        Ok(_) => (words.next().unwrap_or(0), words.next().unwrap_or(0)),
        Err(_) => (0, 0),
    }
}
