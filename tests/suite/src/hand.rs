//! A participant that a test plays itself.

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use rusty_contract::{JoinRequest, RunName};
use rusty_link::{BorrowedFrame, ClientLink, Incoming, LinkError, WaitPolicy};

/// Longer than a run keeps a participant waiting.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// Joins a run under this name.
pub fn join(run: &RunName, name: &str) -> Result<ClientLink, LinkError> {
    let request = JoinRequest::new(name, std::process::id(), 0, "test");
    ClientLink::join(run, &request, WaitPolicy::Block, PATIENCE, &AtomicBool::new(false))
}

/// Waits for the next frame.
pub fn next_frame(link: &mut ClientLink) -> Result<BorrowedFrame, LinkError> {
    match link.wait_frame(PATIENCE, &AtomicBool::new(false))? {
        Incoming::Frame(frame) => Ok(frame),
        Incoming::Nothing => panic!("no frame came"),
    }
}
