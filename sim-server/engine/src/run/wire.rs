//! The shared memory of a run, and the clock that is read next to it.

use std::time::Duration;

use rusty_link::{FrameLoan, LinkError, Peer, ServerLink, monotonic_ns};

/// Reads of the clock while no process sleeps: one in N steps.
const STEPS_PER_CLOCK: u32 = 16;
/// Looks at the data between two checks on processes, for a server that never
/// sleeps.
const LOOKS_PER_CHECK: u32 = 4096;
/// The shortest wait for the pace that is spent asleep.
const WORTH_SLEEPING_NS: u64 = 1_000_000;

/// The link of a run, with the clock.
pub(super) struct Wire {
    pub(super) link: ServerLink,
    /// Looks at the data so far.
    pub(super) looks: u32,
    steps: u32,
    /// The monotonic clock, read a few steps ago at most.
    clock_ns: u64,
    /// This process has slept since.
    slept: bool,
    /// Other runs share this process: what it waits for, it waits for with them, at most
    /// this long, ns.
    pub(super) shared_wait_ns: Option<u64>,
    /// Such a wait is over, and nothing was checked since.
    woke: bool,
}

impl Wire {
    pub(super) fn new(link: ServerLink) -> Self {
        Self {
            link,
            looks: 0,
            steps: 0,
            clock_ns: 0,
            slept: true,
            shared_wait_ns: None,
            woke: false,
        }
    }

    /// The monotonic clock, ns, or what it was a few steps ago: it costs as much
    /// as a look for answers, and what depends on it here are timeouts. Those
    /// may come a little later, never early.
    pub(super) fn now_ns(&mut self) -> u64 {
        self.steps = self.steps.wrapping_add(1);
        if self.slept || self.steps.is_multiple_of(STEPS_PER_CLOCK) {
            self.slept = false;
            self.clock_ns = monotonic_ns();
        }
        self.clock_ns
    }

    /// Lets this process sleep if it waits long for the pace.
    pub(super) fn rest(&mut self, wait_ns: u64) {
        if wait_ns >= WORTH_SLEEPING_NS {
            self.link.rest();
        }
    }

    /// Waits for an event of these processes if `is_idle`. Returns whether it is
    /// time to check on everything else.
    pub(super) fn pause<'p, P>(
        &mut self,
        is_idle: bool,
        peers: impl FnOnce() -> P,
        at_most_ns: u64,
    ) -> bool
    where
        P: Iterator<Item = &'p Peer>,
    {
        let blocked = match &mut self.shared_wait_ns {
            Some(wait_ns) => {
                *wait_ns = at_most_ns;
                std::mem::take(&mut self.woke)
            }
            None => is_idle && self.link.pause(peers, Duration::from_nanos(at_most_ns)),
        };
        self.slept |= blocked;
        self.looks = self.looks.wrapping_add(1);
        blocked || self.looks.is_multiple_of(LOOKS_PER_CHECK)
    }

    /// This process has slept, in a wait for several runs.
    pub(super) fn woke(&mut self) {
        (self.slept, self.woke) = (true, true);
    }

    /// Sends a frame to the participants at these slots. Returns the clock, ns.
    pub(super) fn publish(
        &mut self,
        frame: FrameLoan,
        slots: impl Iterator<Item = usize>,
    ) -> Result<u64, LinkError> {
        self.clock_ns = self.link.publish(frame, slots)?;
        Ok(self.clock_ns)
    }
}
