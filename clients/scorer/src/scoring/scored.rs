//! The ticks that are scored.

use rusty_contract::score;
use rusty_geometry::SE2;

use super::trace::RunTrace;

/// A scored tick: truth and estimate, world frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scored {
    /// Index of the tick.
    pub tick: usize,
    /// The true pose.
    pub truth: SE2,
    /// The believed one.
    pub estimate: SE2,
}

impl Scored {
    /// Distance between estimate and truth, m.
    pub fn position_error_m(&self) -> f64 {
        score::position_error_m(&self.estimate, &self.truth)
    }

    /// Heading of the estimate less heading of the truth, rad in (−π, π].
    pub fn heading_error_rad(&self) -> f64 {
        score::heading_error_rad(&self.estimate, &self.truth)
    }
}

/// The scored ticks of an estimator (index of its name), in order.
pub(super) fn scored(trace: &RunTrace, estimator: usize) -> impl Iterator<Item = Scored> {
    (0..trace.ticks()).filter_map(move |tick| {
        let truth = trace.true_pose(tick)?;
        let estimate = trace.estimate(estimator, tick)?;
        Some(Scored { tick, truth, estimate })
    })
}
