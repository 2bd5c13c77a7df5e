//! What one run came to.

use serde::{Deserialize, Serialize};

use super::row::Row;
use super::track::Track;

/// What one run came to: what a journal keeps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Number of the run in its plan.
    pub run: u64,
    /// A row per estimator, in roster order.
    pub rows: Vec<Row>,
    /// The same of the tracks; none of a run that is not followed.
    pub tracks: Vec<Track>,
    /// What was lost, in words.
    pub lost: Option<String>,
}
