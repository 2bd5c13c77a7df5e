//! Removing what a run has on this machine: memory, sockets, folder.

use std::fs;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::domain_error::{DomainError, io};
use crate::lock::{MEMORY, PREFIX_LENGTH};

/// Where the kernel keeps named shared memory.
pub(crate) const SHARED_MEMORY: &str = "/dev/shm";

/// The files of named shared memory that begin with `prefix`.
pub(crate) fn memory_files(prefix: &str) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(SHARED_MEMORY) else { return Vec::new() };
    entries
        .flatten()
        .filter(|entry| entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes()))
        .map(|entry| entry.path())
        .collect()
}

/// Files of shared memory of this user: those whose names begin as runs' do, or
/// the others.
pub(crate) fn memory_of_runs(of_runs: bool) -> Vec<PathBuf> {
    let me = rustix::process::getuid().as_raw();
    let mut files = memory_files("");
    files.retain(|path| {
        let name = path.file_name().unwrap_or_default().as_encoded_bytes();
        let is_of_run = name.len() > PREFIX_LENGTH
            && name.starts_with(MEMORY.as_bytes())
            && name[MEMORY.len()..PREFIX_LENGTH].iter().all(u8::is_ascii_hexdigit);
        is_of_run == of_runs
            && fs::symlink_metadata(path).is_ok_and(|m| m.is_file() && m.uid() == me)
    });
    files
}

/// Memory of this user's runs that belongs to none of `runs`: names that begin
/// as ours do, but not with one of these prefixes.
pub(crate) fn memory_without_run(runs: impl FnOnce() -> Vec<String>) -> Vec<PathBuf> {
    let mut files = memory_of_runs(true);
    // Asked for after the files: a run that starts meanwhile has its folder
    // before its memory.
    let runs = runs();
    files.retain(|path| {
        let name = path.file_name().unwrap_or_default().as_encoded_bytes();
        !runs.iter().any(|prefix| name.starts_with(prefix.as_bytes()))
    });
    files
}

/// Removes all named shared memory that begins with `prefix`.
pub(crate) fn sweep_memory(prefix: &str) -> Result<(), DomainError> {
    for path in memory_files(prefix) {
        remove_memory(&path)?;
    }
    Ok(())
}

/// Removes one name; whoever has it mapped keeps what it mapped.
pub(crate) fn remove_memory(path: &Path) -> Result<(), DomainError> {
    gone(fs::remove_file(path)).map_err(io(path, "remove"))
}

/// Empties the folder; with `whole`, removes lock and folder too.
pub(crate) fn sweep_folder(folder: &Path, whole: bool) -> Result<(), DomainError> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Ok(());
    };
    for entry in entries.flatten() {
        let path = entry.path();
        if entry.file_name() == "lock" {
            continue;
        }
        let is_folder = entry.file_type().is_ok_and(|t| t.is_dir());
        // Somebody on the way out may still write into a folder being emptied.
        let mut tries = 0;
        loop {
            let removed =
                if is_folder { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
            match removed {
                Err(e) if e.kind() == std::io::ErrorKind::DirectoryNotEmpty && tries < 20 => {
                    tries += 1;
                    std::thread::sleep(Duration::from_millis(1));
                }
                other => break gone(other).map_err(io(&path, "remove"))?,
            }
        }
    }
    if whole {
        let lock = folder.join("lock");
        gone(fs::remove_file(&lock)).map_err(io(&lock, "remove"))?;
        match fs::remove_dir(folder) {
            // A new server may have moved in already.
            Err(e) if e.kind() == std::io::ErrorKind::DirectoryNotEmpty => {}
            other => gone(other).map_err(io(folder, "remove"))?,
        }
    }
    Ok(())
}

/// Something that is not there any more is removed.
fn gone(result: std::io::Result<()>) -> std::io::Result<()> {
    match result {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(()),
        other => other,
    }
}
