//! A thread that ends a server's process when nothing goes on any more: a
//! message may be lost for good, or a client may have died.

use std::process::Child;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use rusty_contract::Exit;

use crate::output::say;

const BETWEEN_LOOKS: Duration = Duration::from_millis(500);
/// Looks without a tick after which nothing will come.
const PATIENCE: u32 = 60;
/// The same when it is asked to stop.
const SHORT_PATIENCE: u32 = 3;

/// The clients of a server, and what the watchdog must know.
#[derive(Clone, Default)]
pub struct Watched {
    clients: Arc<Mutex<Vec<Child>>>,
    ticks: Arc<AtomicU64>,
    over: Arc<AtomicBool>,
    stop: Arc<AtomicBool>,
}

impl Watched {
    /// The clients, which are watched from now on. `stop` is raised when
    /// the server is asked to stop.
    pub fn new(stop: Arc<AtomicBool>) -> std::io::Result<Self> {
        let watched = Self { stop, ..Self::default() };
        let looking = watched.clone();
        std::thread::Builder::new().name("watchdog".to_owned()).spawn(move || looking.look())?;
        Ok(watched)
    }

    pub fn add(&self, client: Child) {
        self.lock().push(client);
    }

    pub fn pids(&self) -> Vec<u32> {
        self.lock().iter().map(Child::id).collect()
    }

    pub fn tick(&self) {
        self.ticks.fetch_add(1, Ordering::Relaxed);
    }

    /// Whether the server is asked to stop.
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// The end of run is out: waits for the clients, and says how those ended
    /// that did not end well.
    pub fn finish(&self) -> Vec<String> {
        // The watchdog still ends those who do not receive the end of run.
        let clients = std::mem::take(&mut *self.lock());
        let mut bad = Vec::new();
        for (place, mut client) in clients.into_iter().enumerate() {
            match client.wait() {
                Ok(status) if status.success() => {}
                Ok(status) => bad.push(format!("client {place}: {status}")),
                Err(e) => bad.push(format!("client {place}: {e}")),
            }
        }
        self.over.store(true, Ordering::Relaxed);
        bad
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Child>> {
        self.clients.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn look(&self) {
        let (mut seen, mut without) = (0, 0);
        loop {
            std::thread::sleep(BETWEEN_LOOKS);
            if self.over.load(Ordering::Relaxed) {
                return;
            }
            let ticks = self.ticks.load(Ordering::Relaxed);
            without = if ticks == seen { without + 1 } else { 0 };
            seen = ticks;
            let patience = if self.is_stopped() { SHORT_PATIENCE } else { PATIENCE };
            let problem = match self.ended() {
                // They end by themselves after the end of run, soon.
                Some(how) if without >= SHORT_PATIENCE => how,
                None if without >= patience => "nobody answers".to_owned(),
                _ => continue,
            };
            if !self.is_stopped() {
                say(format_args!("after {ticks} ticks: {problem}"));
            }
            // The clients go with this process: the kernel was told so.
            std::process::exit(i32::from(Exit::Failed as u8));
        }
    }

    /// The first client that has ended, and how.
    fn ended(&self) -> Option<String> {
        self.lock().iter_mut().enumerate().find_map(|(place, client)| {
            let status = client.try_wait().ok().flatten()?;
            Some(format!("client {place} has ended: {status}"))
        })
    }
}
