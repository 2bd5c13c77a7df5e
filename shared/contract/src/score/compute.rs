//! How long answers took.

use serde::{Deserialize, Serialize};

/// How long the answers of an estimator took. Only a living run knows: a log
/// has the same bytes on every machine, however fast.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ComputeTimes {
    /// From taking the frame to sending the answer, as the estimator reports.
    pub reported: Durations,
    /// From publishing the frame to the answer's arrival, as the server sees it.
    pub observed: Durations,
}

/// Quantiles of durations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Durations {
    /// Median, s.
    pub p50_s: f64,
    /// 99th percentile, s.
    pub p99_s: f64,
    /// The longest, s.
    pub max_s: f64,
}
