//! Folders of runs: one run each, and nothing written over unasked.
//!
//! A run's folder has a marker, `run.json`, written before any participant is
//! started. It names the run and the files that the run may write, and the server
//! holds a lock on it for as long as the run lasts. A folder with a marker is
//! replaced or removed only as a whole, only when it is not locked, and only when
//! everything in it belongs to the run.

mod error;
mod found;
mod marker;

use std::fs::{self, File};
use std::io::ErrorKind;
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock};
use rusty_contract::output::make_folder;

pub use error::{FolderError, FolderProblem};
pub use found::{FoundRun, runs_in};
use marker::MARKER;
pub use marker::{Marker, RunEnd, date_and_time};

/// The folder of a run that is over, locked so that no other process takes it.
pub struct OldRun {
    path: PathBuf,
    _lock: Option<File>,
}

impl OldRun {
    /// Opens the folder of a run that may be removed: nothing else is in it, and
    /// the run is over.
    ///
    /// # Errors
    /// [`FolderError`] names what is in the way.
    pub fn open(path: &Path) -> Result<Self, FolderError> {
        let refused = FolderError::at(path);
        let Some(marker) = Marker::of(path) else {
            return Err(refused(FolderProblem::NotARun));
        };
        let lock = lock_of(path)?;
        if lock.as_ref().is_some_and(|file| !try_lock(file)) {
            return Err(refused(FolderProblem::InUse(marker.run)));
        }
        match names_in(path)?.into_iter().find(|name| !marker.covers(name)) {
            Some(file) => Err(refused(FolderProblem::Foreign(file))),
            None => Ok(Self { path: path.to_owned(), _lock: lock }),
        }
    }

    /// Removes everything in the folder, its marker last: if that is cut short,
    /// the rest is still the folder of a run. Links are removed, not followed.
    ///
    /// # Errors
    /// [`FolderError`] names what could not be removed.
    pub fn clear(&self) -> Result<(), FolderError> {
        let mut names = names_in(&self.path)?;
        names.sort_by_key(|name| name == MARKER);
        for path in names.iter().map(|name| self.path.join(name)) {
            let found = fs::symlink_metadata(&path).map_err(FolderError::at(&path))?;
            let removed = match found.is_dir() {
                true => fs::remove_dir_all(&path),
                false => fs::remove_file(&path),
            };
            removed.map_err(FolderError::at(&path))?;
        }
        Ok(())
    }

    /// Removes the folder with everything in it.
    ///
    /// # Errors
    /// [`FolderError`] names what could not be removed.
    pub fn remove(self) -> Result<(), FolderError> {
        self.clear()?;
        fs::remove_dir(&self.path).map_err(FolderError::at(&self.path))
    }
}

/// A place for a run: looked at, and nothing written yet.
pub struct FreeFolder {
    path: PathBuf,
    /// The run that is replaced.
    old: Option<OldRun>,
}

impl FreeFolder {
    /// Looks whether a run may have this folder: it does not exist, is empty, or,
    /// with `force`, holds nothing but a run that is over. `played` are the logs that
    /// the run reads.
    ///
    /// # Errors
    /// [`FolderError`] names what is in the way.
    pub fn check(path: &Path, force: bool, played: &[&Path]) -> Result<Self, FolderError> {
        let refused = FolderError::at(path);
        let free = |old| Ok(Self { path: path.to_owned(), old });
        // Participants are told of it in JSON.
        if std::path::absolute(path).is_ok_and(|whole| whole.to_str().is_none()) {
            return Err(refused(FolderProblem::NotText));
        }
        match fs::metadata(path) {
            Err(e) if e.kind() == ErrorKind::NotFound => return free(None),
            Err(e) => return Err(refused(e.into())),
            Ok(found) if !found.is_dir() => return Err(refused(FolderProblem::NotAFolder)),
            Ok(_) => {}
        }
        let Some(file) = names_in(path)?.into_iter().next() else { return free(None) };
        if let Ok(real) = fs::canonicalize(path) {
            let is_in =
                |log: &&&Path| fs::canonicalize(log).is_ok_and(|log| log.starts_with(&real));
            if let Some(log) = played.iter().find(is_in) {
                return Err(refused(FolderProblem::HoldsLog(log.display().to_string())));
            }
        }
        let Some(marker) = Marker::of(path) else {
            return Err(refused(FolderProblem::Foreign(file)));
        };
        match force {
            true => OldRun::open(path).map(Some).and_then(free),
            false if is_living(path) => Err(refused(FolderProblem::InUse(marker.run))),
            false => Err(refused(FolderProblem::HoldsRun(marker.run))),
        }
    }

    /// Makes the folder, empties it of the run it held, and writes the marker.
    ///
    /// # Errors
    /// [`FolderError`]: another run was faster, or the folder cannot be written.
    pub fn take(self, marker: Marker) -> Result<RunFolder, FolderError> {
        let Self { path, old } = self;
        let made = !path.exists();
        make_folder(&path).map_err(FolderError::at(&path))?;
        // Participants may run in another folder than the server.
        let path = fs::canonicalize(&path).map_err(FolderError::at(&path))?;
        old.iter().try_for_each(OldRun::clear)?;
        let at = path.join(MARKER);
        let file = File::create_new(&at).map_err(|e| match (e.kind(), Marker::of(&path)) {
            (ErrorKind::AlreadyExists, Some(Marker { run, .. })) => {
                FolderError::at(&path)(FolderProblem::InUse(run))
            }
            _ => FolderError::at(&at)(e),
        })?;
        let folder = RunFolder { path, file, marker, made, has_begun: false };
        // A list of runs may hold it for an instant.
        let locked = flock(&folder.file, FlockOperation::LockExclusive);
        locked.map_err(std::io::Error::from).map_err(FolderError::at(&at))?;
        folder.write()?;
        Ok(folder)
    }
}

/// The folder of a run that goes on. Dropped before the run has begun, it is as
/// empty as it was.
pub struct RunFolder {
    path: PathBuf,
    /// The marker's file, locked.
    file: File,
    marker: Marker,
    /// Whether the folder was made for this run.
    made: bool,
    has_begun: bool,
}

impl RunFolder {
    /// The folder, absolute.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The participants are started: what is in the folder stays.
    pub fn begin(&mut self) {
        self.has_begun = true;
    }

    /// Writes down how the run ended.
    ///
    /// # Errors
    /// [`FolderError`] if the marker cannot be written.
    pub fn end(mut self, end: RunEnd) -> Result<(), FolderError> {
        self.marker.end = Some(end);
        self.write()
    }

    /// Writes the marker. It only ever grows, and is written over in place: on a
    /// full disk the one before it stays readable or is replaced as a whole.
    fn write(&self) -> Result<(), FolderError> {
        let json = serde_json::to_vec(&self.marker).map_err(std::io::Error::from);
        let written = json.and_then(|json| self.file.write_all_at(&json, 0));
        written.map_err(FolderError::at(&self.path.join(MARKER)))
    }
}

impl Drop for RunFolder {
    fn drop(&mut self) {
        if self.has_begun {
            return;
        }
        let old = OldRun { path: self.path.clone(), _lock: None };
        if old.clear().is_ok() && self.made {
            let _ = fs::remove_dir(&self.path);
        }
    }
}

/// Whether the server of a folder's run still holds its lock.
fn is_living(folder: &Path) -> bool {
    matches!(lock_of(folder), Ok(Some(file)) if !try_lock(&file))
}

/// The file that is locked; `None` in a folder without a marker.
fn lock_of(folder: &Path) -> Result<Option<File>, FolderError> {
    let path = folder.join(MARKER);
    match File::options().read(true).write(true).open(&path) {
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
        opened => opened.map(Some).map_err(FolderError::at(&path)),
    }
}

fn try_lock(file: &File) -> bool {
    flock(file, FlockOperation::NonBlockingLockExclusive).is_ok()
}

/// The names in a folder, in order.
fn names_in(folder: &Path) -> Result<Vec<String>, FolderError> {
    let entries = fs::read_dir(folder).map_err(FolderError::at(folder))?;
    let names = entries.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned()));
    let names: std::io::Result<Vec<String>> = names.collect();
    let mut names = names.map_err(FolderError::at(folder))?;
    names.sort();
    Ok(names)
}

#[cfg(test)]
mod tests;
