//! Ctrl-C and SIGTERM: once to end the run well, twice to end it now.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rusty_contract::{Exit, RunName};
use rusty_link::Domain;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use super::children::Children;
use super::group::kill_group;

/// The wish to stop.
#[derive(Clone)]
pub struct Stop {
    flag: Arc<AtomicBool>,
    groups: Arc<Mutex<Vec<u32>>>,
}

impl Stop {
    /// Listens for signals on behalf of `run`. The first raises the flag; the
    /// second kills the participants, removes what the run has in shared
    /// memory, and ends this process.
    ///
    /// # Errors
    /// [`std::io::Error`] if signals cannot be listened for.
    pub fn listen(run: &RunName) -> std::io::Result<Self> {
        let stop = Self { flag: Arc::default(), groups: Arc::default() };
        let mut signals = Signals::new([SIGINT, SIGTERM])?;
        let (heard, run) = (stop.clone(), run.clone());
        std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
            for _ in signals.forever() {
                if heard.flag.swap(true, Ordering::Relaxed) {
                    let groups = heard.groups.lock().unwrap_or_else(PoisonError::into_inner);
                    groups.iter().copied().for_each(kill_group);
                    Domain::remove_traces(&run);
                    std::process::exit(i32::from(Exit::Lost as u8));
                }
            }
        })?;
        Ok(stop)
    }

    /// Raised once somebody wants the run to stop.
    #[must_use]
    pub fn flag(&self) -> &AtomicBool {
        &self.flag
    }

    /// Whom the second signal ends.
    pub fn covers(&self, children: &Children) {
        let mut groups = self.groups.lock().unwrap_or_else(PoisonError::into_inner);
        *groups = children.groups().collect();
    }
}
