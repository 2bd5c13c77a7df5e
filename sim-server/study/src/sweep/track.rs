//! Where truth and estimate were at some ticks of a run.

use rusty_geometry::SE2;
use serde::{Deserialize, Serialize};

/// Truth and estimate at some ticks of one run: for spreads over time, and for
/// drawings. The ticks are the same for all seeds of a cell, evenly spaced up
/// to and with the last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Track {
    /// Index of the cell.
    pub cell: usize,
    /// The seed of all noise.
    pub seed: u64,
    /// Name in the roster.
    pub estimator: String,
    /// In order of time. Ticks without an estimate or a truth are left out.
    pub samples: Vec<Sample>,
}

/// One of those ticks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Time at the end of the tick, s.
    pub time_s: f64,
    /// Distance truly driven up to then, m.
    pub distance_m: f64,
    /// The true pose, world frame.
    pub truth: SE2,
    /// The estimate, world frame.
    pub estimate: SE2,
    /// Normalised squared error of the estimate, where a covariance was reported
    /// that has one.
    pub nees: Option<f64>,
}
