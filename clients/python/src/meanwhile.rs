//! Joining and waiting for the next run on a thread, so that the thread of Python can look
//! for Ctrl-C meanwhile.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::prelude::*;
use rusty_clients::{ClientArgs, Session as Sdk};

use crate::errors::{RustyError, exception};
use crate::gate::Lone;

/// How long a wait lasts before Python is asked whether it is interrupted.
pub const SLICE: Duration = Duration::from_millis(50);

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
    loop {
        let receiver = &mut joined;
        match py.detach(move || receiver.recv_timeout(SLICE)) {
            Ok(session) => {
                // From here on no other thread knows of it.
                let _ = joiner.join();
                return session.map_err(exception);
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                return Err(RustyError::new_err("joining broke off; its message is above"));
            }
        }
        if let Err(interrupt) = py.check_signals() {
            stop.store(true, Ordering::Relaxed);
            // It learns of it in a moment, and whatever it has brought about is
            // dropped with a leave message.
            py.detach(move || drop((joined.recv(), joiner.join())));
            return Err(interrupt);
        }
    }
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
        let mut interrupt = None;
        loop {
            let receiver = &mut asked;
            match py.detach(move || receiver.recv_timeout(SLICE)) {
                Ok(next) => return interrupt.map_or_else(|| next.map_err(exception), Err),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    let text = "asking for the next run broke off; its message is above";
                    return Err(RustyError::new_err(text));
                }
            }
            if let Err(error) = py.check_signals() {
                // The thread learns of it in a moment, and leaves.
                stop.store(true, Ordering::Relaxed);
                interrupt = Some(error);
            }
        }
    })
}
