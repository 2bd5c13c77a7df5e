//! The file system of shared memory: whether it can be used, how much of it is
//! free, and the allocation of a run's files.
//!
//! The transport makes sparse files. The kernel allocates a page at the first
//! write, and where no page is left, it kills the writer with SIGBUS. So a server
//! allocates what its run will write before the first tick, where a full file
//! system is an error with a remedy.

use std::fs::{self, File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use rustix::fs::{FallocateFlags, StatVfs, fallocate, statvfs};
use rustix::io::Errno;

use crate::LinkError;

/// The file system of the kernel's shared memory.
pub(crate) const SHARED_MEMORY: &str = "/dev/shm";

/// Shared memory that must be free when a run starts: the files of the server and
/// of sixteen participants as [`reserve`] allocates them (5 MB), and their copies
/// for participants that come back.
pub(crate) const RUN_BYTES: u64 = 12 << 20;

/// Shared memory that must be free where a process opens ports.
pub(crate) const PORTS_BYTES: u64 = 1 << 20;

/// Bytes from the beginning of a file that [`reserve`] allocates at most. The
/// transport writes to the lowest free place of a file: this is room for 100
/// frames, and 80 wait or are held at most.
const ALLOCATED_BYTES: u64 = 1 << 20;

/// What there is to say of shared memory on this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MemoryState {
    /// Where it is mounted.
    pub path: &'static str,
    /// Why no file can be made, written and removed there; `None` if it can.
    pub problem: Option<String>,
    /// Bytes that this user may still fill; 0 where the kernel does not say.
    pub free_bytes: u64,
}

/// Tries shared memory: makes a file of one page, writes it, removes it.
#[must_use]
pub fn memory_state() -> MemoryState {
    state_of(SHARED_MEMORY)
}

/// Bytes of shared memory that this user may still fill; 0 where the kernel does
/// not say.
pub(crate) fn free_bytes() -> u64 {
    free_at(SHARED_MEMORY)
}

/// Checks that `needed_bytes` of shared memory are free.
///
/// # Errors
/// [`LinkError::NoRoom`] if they are not.
pub(crate) fn ensure_room(needed_bytes: u64) -> Result<(), LinkError> {
    let Ok(room) = statvfs(SHARED_MEMORY) else { return Ok(()) };
    let free_bytes = free_of(&room);
    // A file system without a limit has no size.
    if room.f_blocks > 0 && free_bytes < needed_bytes {
        return Err(LinkError::NoRoom { needed_bytes, free_bytes });
    }
    Ok(())
}

/// Allocates the pages that a run writes to the files in its folder.
///
/// # Errors
/// [`LinkError::NoRoom`] if the file system is full.
pub(crate) fn reserve(folder: &Path) -> Result<(), LinkError> {
    for path in files_in(folder) {
        // A socket cannot be opened, and another process may remove its files.
        let Ok(file) = OpenOptions::new().write(true).open(&path) else { continue };
        let length = file.metadata().map_or(0, |found| found.len());
        let needed_bytes = length.min(ALLOCATED_BYTES);
        if fallocate(&file, FallocateFlags::KEEP_SIZE, 0, needed_bytes) == Err(Errno::NOSPC) {
            return Err(LinkError::NoRoom { needed_bytes, free_bytes: free_bytes() });
        }
    }
    Ok(())
}

fn free_at(path: &str) -> u64 {
    statvfs(path).map_or(0, |room| free_of(&room))
}

fn free_of(room: &StatVfs) -> u64 {
    room.f_bavail.saturating_mul(room.f_frsize)
}

fn state_of(path: &'static str) -> MemoryState {
    let free_bytes = free_at(path);
    let problem = write_a_page(Path::new(path)).err().map(|error| error.to_string());
    MemoryState { path, problem, free_bytes }
}

/// All files in a folder and its folders.
pub(crate) fn files_in(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let (folders, mut files): (Vec<_>, Vec<_>) =
        entries.flatten().map(|entry| entry.path()).partition(|path| path.is_dir());
    files.extend(folders.iter().flat_map(|folder| files_in(folder)));
    files
}

fn write_a_page(folder: &Path) -> std::io::Result<()> {
    let path = folder.join(format!("rusty-probe-{}", std::process::id()));
    let written = File::create_new(&path).and_then(|mut page| page.write_all(&[0; 4096]));
    written.and(fs::remove_file(&path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shared_memory_can_be_written_where_these_tests_run() {
        let state = memory_state();
        assert_eq!(state.problem, None);
        assert!(state.free_bytes > 0);
    }

    #[test]
    fn a_place_that_is_none_is_a_problem() {
        let state = state_of("/dev/null/nowhere");
        assert!(state.problem.unwrap().contains("Not a directory"));
        assert_eq!(state.free_bytes, 0);
    }
}
