//! The runs of the robots of one world: in one process, in step.
//!
//! Every run has its own shared memory, participants and log, and goes on by itself until
//! it waits. Its source lets no tick happen before all robots are ready for it.

use std::time::Duration;

use rusty_link::{LinkError, Peer, ServerLink};

use super::{Outcome, Run};

impl Run<'_> {
    /// Drives several runs to their ends, and waits for their participants to end.
    ///
    /// # Errors
    /// [`LinkError`] if shared memory fails under one of them.
    pub fn drive_together(mut runs: Vec<Self>) -> Result<Vec<Outcome>, LinkError> {
        for run in &mut runs {
            run.wire.shared_wait_ns = Some(u64::MAX);
        }
        while runs.iter().any(|run| !run.finished) {
            let mut is_idle = true;
            for run in &mut runs {
                is_idle &= !run.work()?;
            }
            if is_idle && !runs.iter().any(|run| !run.finished && run.wire.link.yielded()) {
                block(&mut runs);
            }
        }
        Ok(runs.into_iter().map(Run::outcome).collect())
    }

    /// Goes on until there is nothing to do but wait. Returns whether there was anything.
    fn work(&mut self) -> Result<bool, LinkError> {
        let mut worked = false;
        while !self.finished && self.step()? {
            worked = true;
        }
        Ok(worked)
    }
}

/// Sleeps until something happens in one of the runs, or the first of their times is over.
fn block(runs: &mut [Run<'_>]) {
    let mut at_most_ns = u64::MAX;
    let (mut links, mut peers) = (Vec::new(), Vec::<&Peer>::new());
    for run in runs.iter_mut().filter(|run| !run.finished) {
        let Run { wire, participants, lockstep, .. } = run;
        at_most_ns = at_most_ns.min(wire.shared_wait_ns.unwrap_or(u64::MAX));
        peers.extend(participants.present(lockstep));
        links.push(&mut wire.link);
    }
    ServerLink::block_all(&mut links, &peers, Duration::from_nanos(at_most_ns));
    runs.iter_mut().for_each(|run| run.wire.woke());
}
