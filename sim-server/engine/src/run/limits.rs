//! Limits and signal actions that this process has from its parent.

use std::sync::Arc;

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use signal_hook::consts::SIGXFSZ;
use thiserror::Error;

/// Descriptors that the server opens for itself, and for each participant.
const OWN_FILES: u64 = 64;
const FILES_EACH: u64 = 10;
/// Room for the largest segment of shared memory that a run has, bytes.
const LARGEST_FILE_BYTES: u64 = 32 << 20;

/// A limit under which no run is possible.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "starting the run failed: {what} (`ulimit {option}`): expected a limit of at least {least}, \
     got {found}; raise it in the shell that starts sim-server"
)]
pub struct LimitError {
    what: &'static str,
    option: &'static str,
    least: u64,
    found: u64,
}

/// Undoes what a parent may leave to its children. With SIGCHLD ignored (`trap ''
/// CHLD`) the kernel forgets ended children at once, with their numbers. SIGXFSZ
/// (`ulimit -f`) ends a process that an error would reach otherwise.
pub fn prepare_process() {
    // SAFETY: the default action runs no code of this process.
    unsafe { libc::signal(libc::SIGCHLD, libc::SIG_DFL) };
    // Without it the signal ends this process, as before.
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::default());
}

/// Checks that runs of N participants in all are possible; the soft limit of open
/// files is raised if it has to be.
///
/// # Errors
/// [`LimitError`] names the limit, its value and the least that is needed.
pub fn check_limits(runs: usize, participants: usize) -> Result<(), LimitError> {
    let least = OWN_FILES * runs as u64 + FILES_EACH * participants as u64;
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    if current.is_some_and(|found| found < least) {
        let raised = Rlimit { current: Some(least), maximum };
        let found = current.unwrap_or_default();
        setrlimit(Resource::Nofile, raised).map_err(|_| LimitError {
            what: "open files",
            option: "-n",
            least,
            found,
        })?;
    }
    // Nothing is raised here: the limit is there to keep files small.
    match getrlimit(Resource::Fsize).current {
        Some(found) if found < LARGEST_FILE_BYTES => Err(LimitError {
            what: "bytes of a file, shared memory included",
            option: "-f",
            least: LARGEST_FILE_BYTES,
            found,
        }),
        _ => Ok(()),
    }
}

/// Returns what to do about an error of starting a process or thread.
pub(super) fn remedy(error: &std::io::Error) -> &'static str {
    match error.raw_os_error() {
        Some(libc::EAGAIN) => "; end other processes of this user, or raise `ulimit -u`",
        Some(libc::EMFILE) => "; raise `ulimit -n`",
        Some(libc::ENOMEM) => "; end other processes, or raise `ulimit -v`",
        _ => "; check that it is there and that this user may execute it",
    }
}
