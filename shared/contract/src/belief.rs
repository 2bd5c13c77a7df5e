//! What a filter holds possible, for looking at.
//!
//! An answer carries one pose and a covariance. A belief that has several peaks
//! or no parameters at all does not fit into that: it is shown as poses with
//! weights, beside the run. Nobody waits for it and no digest knows it.

use bytemuck::{Pod, Zeroable};

/// A pose and how much of the belief is there.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct WeightedPose {
    /// World frame, m.
    pub x_m: f64,
    /// World frame, m.
    pub y_m: f64,
    /// World frame, rad.
    pub theta_rad: f64,
    /// Its share; those of a belief add up to 1, or are all 0 where the filter
    /// has none.
    pub weight: f64,
}

/// What the poses of a belief are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BeliefKind {
    /// Samples.
    Particles,
    /// Centres of the cells of a histogram.
    Histogram,
}
