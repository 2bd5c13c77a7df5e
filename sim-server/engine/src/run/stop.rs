//! Ctrl-C and SIGTERM: once to end the run well, twice to end it now.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rusty_contract::{Exit, RunName};
use rusty_link::Domain;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use super::group::Groups;

/// The wish to stop.
#[derive(Clone)]
pub struct Stop {
    flag: Arc<AtomicBool>,
    groups: Groups,
}

impl Stop {
    /// Listens for signals on behalf of `run`. The first raises the flag; the
    /// second kills the participants, removes what the run has in shared
    /// memory, and ends this process.
    ///
    /// # Errors
    /// [`std::io::Error`] if signals cannot be listened for.
    pub fn listen(run: &RunName) -> std::io::Result<Self> {
        let stop = Self { flag: Arc::default(), groups: Groups::default() };
        let mut signals = Signals::new([SIGINT, SIGTERM])?;
        let (heard, run) = (stop.clone(), run.clone());
        std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
            for _ in signals.forever() {
                if heard.flag.swap(true, Ordering::Relaxed) {
                    heard.groups.end_with_all(|| {
                        Domain::remove_traces(&run);
                        std::process::exit(i32::from(Exit::Lost as u8));
                    });
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

    /// The groups that the second signal ends.
    #[must_use]
    pub fn groups(&self) -> &Groups {
        &self.groups
    }
}
