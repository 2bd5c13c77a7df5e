//! Frames and tallies where they are in shared memory.

use std::ops::Deref;

use iceoryx2::sample::Sample;
use rusty_contract::{Frame, Tally};

use crate::services::{Ipc, WireFrame, WireTally};
use crate::wait::monotonic_ns;

/// A frame where it lies. It stays valid for as long as it is held.
pub struct BorrowedFrame {
    pub(crate) sample: Sample<Ipc, WireFrame, ()>,
    pub(crate) taken_ns: u64,
}

impl Deref for BorrowedFrame {
    type Target = Frame;

    fn deref(&self) -> &Frame {
        &self.sample.payload().0
    }
}

impl BorrowedFrame {
    /// The monotonic clock when the frame was taken, ns.
    #[must_use]
    pub fn taken_ns(&self) -> u64 {
        self.taken_ns
    }

    /// Counts as taken now: for a participant that holds its answer back and does not
    /// compute meanwhile.
    pub fn restart_clock(&mut self) {
        self.taken_ns = monotonic_ns();
    }
}

/// The answers of a tick where they lie. They stay valid for as long as they
/// are held.
pub struct BorrowedTally(pub(crate) Sample<Ipc, WireTally, ()>);

impl Deref for BorrowedTally {
    type Target = Tally;

    fn deref(&self) -> &Tally {
        &self.0.payload().0
    }
}
