//! Runs with an original: replays and forks.

use rusty_engine::source::{FrameSource, Simulated};

use super::comparison::Comparison;
use super::fork::{Branch, Fork};
use super::replay::Recording;

/// A source that may compare its run with an original.
pub trait Compare: FrameSource {
    /// The comparison of the answers with the recorded ones.
    fn comparison(&self) -> Option<&Comparison> {
        None
    }

    /// The comparison of a fork with its original.
    fn fork(&self) -> Option<&Fork> {
        None
    }
}

impl Compare for Simulated<'_> {}

impl Compare for Recording {
    fn comparison(&self) -> Option<&Comparison> {
        Some(&self.comparison)
    }
}

impl Compare for Branch {
    fn comparison(&self) -> Option<&Comparison> {
        Some(&self.comparison)
    }

    fn fork(&self) -> Option<&Fork> {
        Some(&self.fork)
    }
}
