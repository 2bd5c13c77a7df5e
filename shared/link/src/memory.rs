//! The kernel's place for named shared memory: may this process use it, and how
//! much room is there?

use std::fs::{self, File};
use std::io::Write as _;
use std::path::Path;

use rustix::fs::statvfs;

use crate::sweep::SHARED_MEMORY;

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

fn free_at(path: &str) -> u64 {
    statvfs(path).map_or(0, |room| room.f_bavail.saturating_mul(room.f_frsize))
}

fn state_of(path: &'static str) -> MemoryState {
    let free_bytes = free_at(path);
    let problem = write_a_page(Path::new(path)).err().map(|error| error.to_string());
    MemoryState { path, problem, free_bytes }
}

fn write_a_page(folder: &Path) -> std::io::Result<()> {
    // No name of a run's memory has a dash, so no sweep takes this for one.
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
