//! Joining and waiting for the next run on a thread, so that the thread of Python can look
//! for Ctrl-C meanwhile.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::prelude::*;
use rusty_clients::{ClientArgs, Session as Sdk};

use crate::errors::{RustyError, exception};
use crate::gate::Lone;

/// How long a wait lasts before Python is asked whether it is interrupted.
pub const SLICE: Duration = Duration::from_millis(50);

/// Waits for what a thread sends. A signal raises `stop`, of which the thread learns in a
/// moment; what it has brought about by then is dropped.
fn wait<T: Send>(
    py: Python<'_>,
    received: &mut Receiver<T>,
    stop: &AtomicBool,
    what: &str,
) -> PyResult<T> {
    let mut interrupt = None;
    loop {
        let receiver = &mut *received;
        match py.detach(move || receiver.recv_timeout(SLICE)) {
            Ok(found) => return interrupt.map_or(Ok(found), Err),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                let text = format!("{what} broke off; its message is above");
                return Err(RustyError::new_err(text));
            }
        }
        if let Err(error) = py.check_signals() {
            stop.store(true, Ordering::Relaxed);
            interrupt = Some(error);
        }
    }
}

/// Joins on a thread.
pub fn join_meanwhile(
    py: Python<'_>,
    args: ClientArgs,
    stop: &Arc<AtomicBool>,
) -> PyResult<Lone<Sdk>> {
    let (done, mut joined) = channel();
    let raised = Arc::clone(stop);
    let joiner = std::thread::spawn(move || {
        // SAFETY: this thread has the session alone, and ends when it has sent it to
        // the one that makes the gate.
        let lone = |session| unsafe { Lone::new(session) };
        let _ = done.send(Sdk::join_until(&args, raised).map(lone));
    });
    let session = wait(py, &mut joined, stop, "joining");
    // From here on no other thread knows of it.
    let _ = joiner.join();
    session?.map_err(exception)
}

/// Asks for the next run on a thread.
pub fn next_run_meanwhile(
    py: Python<'_>,
    session: &mut Lone<Sdk>,
    stop: &AtomicBool,
) -> PyResult<Option<rusty_contract::Start>> {
    std::thread::scope(|scope| {
        let (done, mut asked) = channel();
        scope.spawn(move || {
            let next = session.get_mut().next_run();
            let _ = done.send(next.map(|run| run.map(|run| run.start().clone())));
        });
        wait(py, &mut asked, stop, "asking for the next run")?.map_err(exception)
    })
}
