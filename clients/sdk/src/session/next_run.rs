//! One run after the other, by one process.

use std::sync::atomic::Ordering;

use rusty_link::LinkError;

use super::{Session, Source};
use crate::ClientError;

impl Session {
    /// The run that was joined, then the next run of its series; `None` after the last.
    /// A server that sweeps many seeds offers more than one run to a process, others and
    /// logs have one. What a run begins with is in [`start`](Self::start), which is
    /// another one in each run: a filter that is made from it anew answers as in a
    /// process that has just been started.
    ///
    /// A program that does not call this takes part in one run, and the server starts it
    /// again for the next.
    ///
    /// # Errors
    /// [`ClientError::Unusable`] if the current run has not ended; [`ClientError::Link`]
    /// if the server has ended.
    pub fn next_run(&mut self) -> Result<Option<&mut Self>, ClientError> {
        if !std::mem::replace(&mut self.is_begun, true) {
            return Ok(Some(self));
        }
        let Source::Live(link) = &mut self.source else { return Ok(None) };
        if self.ending.is_none() {
            self.failed = true;
            let remedy = "take all its ticks, then ask for the next run";
            return Err(ClientError::Unusable(format!("the run has not ended: {remedy}")));
        }
        let stopped = self.stop.load(Ordering::Relaxed);
        if stopped || self.failed || self.has_left || !self.start.more_runs {
            return Ok(None);
        }
        self.has_left = true;
        match link.next_run(&self.stop) {
            Ok(true) => {}
            Ok(false) | Err(LinkError::Stopped) => return Ok(None),
            Err(error) => return Err(error.into()),
        }
        self.start = link.start().clone();
        (self.last_tick, self.ending) = (None, None);
        (self.has_left, self.is_behind, self.ends_run) = (false, false, false);
        Ok(Some(self))
    }
}
