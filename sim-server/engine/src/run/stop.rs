//! Ctrl-C and SIGTERM: once to end the run well, twice to end it now.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rusty_contract::{Exit, RunName};
use rusty_link::Domain;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use super::error::RunError;
use super::group::Groups;

/// A request to stop.
#[derive(Clone)]
pub struct Stop {
    flag: Arc<AtomicBool>,
    groups: Groups,
}

impl Stop {
    /// Listens for signals on behalf of `runs`. The first raises the flag; the
    /// second kills the participants, removes what the runs have in shared
    /// memory, and ends this process.
    ///
    /// # Errors
    /// [`RunError::Signals`] if signals cannot be listened for.
    pub fn listen(runs: &[RunName]) -> Result<Self, RunError> {
        Self::listen_for(runs).map_err(RunError::Signals)
    }

    fn listen_for(runs: &[RunName]) -> std::io::Result<Self> {
        let stop = Self { flag: Arc::default(), groups: Groups::default() };
        let mut signals = Signals::new([SIGINT, SIGTERM])?;
        let (received, runs) = (stop.clone(), runs.to_vec());
        std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
            for _ in signals.forever() {
                if received.flag.swap(true, Ordering::Relaxed) {
                    received.groups.end_with_all(|| {
                        runs.iter().for_each(Domain::remove_traces);
                        std::process::exit(i32::from(Exit::Lost as u8));
                    });
                }
            }
        })?;
        Ok(stop)
    }

    /// A request that this flag makes: for a process that has its own signal handlers.
    #[must_use]
    pub fn of(flag: Arc<AtomicBool>) -> Self {
        Self { flag, groups: Groups::default() }
    }

    /// Whether the run was asked to stop.
    #[must_use]
    pub fn is_raised(&self) -> bool {
        self.flag.load(Ordering::Relaxed)
    }

    /// Asks the run to stop.
    pub fn raise(&self) {
        self.flag.store(true, Ordering::Relaxed);
    }

    /// Takes the request back, for a next run.
    pub fn lower(&self) {
        self.flag.store(false, Ordering::Relaxed);
    }

    /// The groups that the second signal ends.
    #[must_use]
    pub(super) fn groups(&self) -> &Groups {
        &self.groups
    }
}
