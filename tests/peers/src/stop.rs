//! Ctrl-C and SIGTERM: once to end well, twice to end now.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};

use rustix::process::{Pid, Signal, kill_process, kill_process_group};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

/// The wish to stop, and the server it is passed on to.
#[derive(Clone, Default)]
pub struct Stop {
    flag: Arc<AtomicBool>,
    /// The server's process, which leads a group; 0 if there is none.
    server: Arc<AtomicI32>,
}

impl Stop {
    /// Listens for signals.
    pub fn listen() -> std::io::Result<Self> {
        let stop = Self::default();
        let mut signals = Signals::new([SIGINT, SIGTERM])?;
        let received = stop.clone();
        std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
            for _ in signals.forever() {
                let again = received.flag.swap(true, Ordering::SeqCst);
                received.tell(again);
            }
        })?;
        Ok(stop)
    }

    /// Whether the program was asked to stop.
    pub fn is_raised(&self) -> bool {
        self.flag.load(Ordering::SeqCst)
    }

    /// The server's process from now on; 0 if there is none.
    pub fn covers(&self, pid: u32) {
        self.server.store(i32::try_from(pid).unwrap_or(0), Ordering::SeqCst);
        // The wish may have come just before.
        if self.is_raised() {
            self.tell(false);
        }
    }

    fn tell(&self, now: bool) {
        let Some(pid) = Pid::from_raw(self.server.load(Ordering::SeqCst)) else { return };
        let _ = match now {
            false => kill_process(pid, Signal::TERM),
            true => kill_process_group(pid, Signal::KILL),
        };
    }
}
