//! Look at the data, yield, then block for a bounded while.
//!
//! A waiter looks for data for an *awake time*; then it blocks on a descriptor, in bounded
//! slices. Between looks it gives its core away (`sched_yield`), except in its first
//! microseconds while no process seems to want the core: a yield that returns late says that
//! one does, and the waits after it yield at once.
//!
//! Awake times and the moments at which waiting began travel with the data, so
//! a sender can tell whether its receiver may be asleep: only then does it pay
//! for a wake-up. While everyone is awake a tick needs no blocking system call.
//!
//! The sender reads the clock *after* its data is visible. If the receiver's
//! awake time is then less than half over, the receiver will still look at
//! least once; otherwise it is woken. A wake-up lost all the same costs one
//! slice, never a hang.

use std::cell::Cell;
use std::os::fd::BorrowedFd;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::time::{ClockId, clock_gettime};

/// How a process waits for the other side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WaitPolicy {
    /// Yield for up to 400 µs, then block.
    #[default]
    Balanced,
    /// Yield for ever: lowest latency, one core per process.
    Spin,
    /// Block at once: lowest use of the processor.
    Block,
}

impl WaitPolicy {
    /// How long a waiter looks before it may sleep, ns.
    #[must_use]
    pub fn awake_ns(self) -> u64 {
        match self {
            Self::Balanced => 400_000,
            Self::Spin => u64::MAX,
            Self::Block => 0,
        }
    }
}

impl std::str::FromStr for WaitPolicy {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "balanced" => Ok(Self::Balanced),
            "spin" => Ok(Self::Spin),
            "block" => Ok(Self::Block),
            other => Err(format!("{other:?} is no way to wait; use balanced, spin or block")),
        }
    }
}

impl std::fmt::Display for WaitPolicy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Balanced => "balanced",
            Self::Spin => "spin",
            Self::Block => "block",
        })
    }
}

/// The system-wide monotonic clock, ns.
#[must_use]
pub fn monotonic_ns() -> u64 {
    let t = clock_gettime(ClockId::Monotonic);
    t.tv_sec as u64 * 1_000_000_000 + t.tv_nsec as u64
}

/// Whether a receiver that began to wait at `since_ns` may be asleep at `now_ns`.
pub(crate) fn may_sleep(now_ns: u64, since_ns: u64, awake_ns: u64) -> bool {
    awake_ns != u64::MAX && now_ns.saturating_sub(since_ns) >= awake_ns / 2
}

/// How long a wait looks without a yield, ns: longer than an answer takes that is made by a
/// process on another core.
const KEEP_CORE_NS: u64 = 3_000;

/// A yield longer than this ran another process, ns. With no other process on the core it is a
/// system call of 0.2 to 0.6 µs.
const RAN_ANOTHER_NS: u64 = 1_500;

/// How many waits yield at once after a yield that ran another process.
const WAITS_IN_TURN: u32 = 64;

thread_local! {
    /// How many of the next waits of this thread yield at once.
    static IN_TURN: Cell<u32> = const { Cell::new(0) };
}

/// Until when a wait that began at `since_ns` keeps its core.
fn keep_until_ns(since_ns: u64) -> u64 {
    match IN_TURN.get() {
        0 => since_ns.saturating_add(KEEP_CORE_NS),
        waits => {
            IN_TURN.set(waits - 1);
            0
        }
    }
}

/// One wait: looks, yields, then blocks in growing slices.
#[derive(Clone)]
pub(crate) struct Waiter {
    keep_until_ns: u64,
    awake_until_ns: u64,
    slice: Duration,
}

/// How often a process that never sleeps looks around itself, in looks for
/// data.
pub(crate) const LOOKS_BETWEEN_CHECKS: u32 = 4096;

/// First and longest slice of blocking.
const FIRST_SLICE: Duration = Duration::from_millis(2);
const LONGEST_SLICE: Duration = Duration::from_millis(20);

impl Waiter {
    /// No bound but that of the slice.
    pub(crate) const FOR_EVER: Duration = Duration::MAX;

    /// A wait that began at `since_ns`.
    pub(crate) fn new(policy: WaitPolicy, since_ns: u64) -> Self {
        Self {
            keep_until_ns: keep_until_ns(since_ns),
            awake_until_ns: since_ns.saturating_add(policy.awake_ns()),
            slice: FIRST_SLICE,
        }
    }

    /// Sleeps from now on: what is waited for is known to be far, and a process that
    /// brings it wakes this process in any case. One who never sleeps does not
    /// begin to.
    pub(crate) fn rest(&mut self) {
        if self.awake_until_ns != u64::MAX {
            self.awake_until_ns = 0;
        }
    }

    /// Stays awake for no longer than `awake_ns` after `since_ns`.
    pub(crate) fn at_most_awake(&mut self, since_ns: u64, awake_ns: u64) {
        if self.awake_until_ns != u64::MAX {
            self.awake_until_ns = self.awake_until_ns.min(since_ns.saturating_add(awake_ns));
        }
    }

    /// Whether it is still in its awake time; if so, the core was given away once, or
    /// kept because it is early and no process wants it.
    pub(crate) fn yielded(&self) -> bool {
        // Read at every look: on a busy machine one yield can take longer than
        // the whole awake time, and who sleeps is woken sooner.
        let now_ns = monotonic_ns();
        if now_ns >= self.awake_until_ns {
            return false;
        }
        if now_ns < self.keep_until_ns {
            std::hint::spin_loop();
        } else {
            std::thread::yield_now();
            if monotonic_ns() - now_ns > RAN_ANOTHER_NS {
                IN_TURN.set(WAITS_IN_TURN);
            }
        }
        true
    }

    /// Blocks until one of `fds` is readable, `at_most` is over, or a slice is.
    pub(crate) fn block(&mut self, fds: &mut [PollFd<'_>], at_most: Duration) {
        let slice = self.slice.min(at_most);
        self.slice = (self.slice * 2).min(LONGEST_SLICE);
        let timeout = Timespec { tv_sec: 0, tv_nsec: i64::from(slice.subsec_nanos()) };
        // Interrupted or timed out: the caller looks at data and flags.
        let _ = poll(fds, Some(&timeout));
    }
}

/// A descriptor to wait for.
pub(crate) fn readable(fd: BorrowedFd<'_>) -> PollFd<'_> {
    PollFd::from_borrowed_fd(fd, PollFlags::IN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_receiver_is_woken_from_half_its_awake_time_on() {
        assert!(!may_sleep(1_000, 900, 400));
        assert!(may_sleep(1_100, 900, 400));
        assert!(may_sleep(1_000, 1_000, 0));
        assert!(!may_sleep(u64::MAX, 0, u64::MAX));
    }

    #[test]
    fn who_never_sleeps_does_not_begin_to() {
        let (now, mut spin) = (monotonic_ns(), Waiter::new(WaitPolicy::Spin, 7));
        spin.rest();
        spin.at_most_awake(now, 0);
        assert!(spin.yielded());
        let mut balanced = Waiter::new(WaitPolicy::Balanced, now + 1_000_000_000);
        assert!(balanced.yielded());
        balanced.rest();
        assert!(!balanced.yielded());
    }

    #[test]
    fn a_core_that_is_wanted_is_given_away_at_once_for_a_number_of_waits() {
        let keeps = || Waiter::new(WaitPolicy::Balanced, 7).keep_until_ns == 7 + KEEP_CORE_NS;
        assert!(keeps());
        IN_TURN.set(WAITS_IN_TURN);
        assert!((0..WAITS_IN_TURN).all(|_| !keeps()));
        assert!(keeps());
    }

    #[test]
    fn policies_have_names() {
        for policy in [WaitPolicy::Balanced, WaitPolicy::Spin, WaitPolicy::Block] {
            assert_eq!(policy.to_string().parse(), Ok(policy));
        }
        assert!("sleep".parse::<WaitPolicy>().unwrap_err().contains("balanced"));
    }
}
