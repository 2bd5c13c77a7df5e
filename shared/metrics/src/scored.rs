//! A tick with a truth and an estimate, and how far they are apart.

use rusty_geometry::{SE2, trig, wrap_angle};

/// Distance between an estimate and its truth, m.
#[must_use]
pub fn position_error_m(estimate: &SE2, truth: &SE2) -> f64 {
    trig::hypot(estimate.x() - truth.x(), estimate.y() - truth.y())
}

/// Heading of the estimate less heading of the truth, rad in (−π, π].
#[must_use]
pub fn heading_error_rad(estimate: &SE2, truth: &SE2) -> f64 {
    wrap_angle(estimate.theta() - truth.theta())
}

/// A scored tick: truth and estimate, world frame, both made of finite numbers.
#[derive(Clone, Copy, Debug)]
pub struct Scored {
    /// Index of the tick.
    pub tick: usize,
    /// True pose.
    pub truth: SE2,
    /// Estimated pose.
    pub estimate: SE2,
}

impl Scored {
    /// Distance between estimate and truth, m.
    #[must_use]
    pub fn position_error_m(&self) -> f64 {
        position_error_m(&self.estimate, &self.truth)
    }

    /// Heading of the estimate less heading of the truth, rad in (−π, π].
    #[must_use]
    pub fn heading_error_rad(&self) -> f64 {
        heading_error_rad(&self.estimate, &self.truth)
    }
}
