//! One setting of the swept fields, and all results of a sweep.

use std::sync::Arc;

use rusty_contract::RunConfig;

use super::row::Row;
use super::track::Track;

/// One combination of the swept fields' values.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// The swept fields and their values here, as they were written, in the
    /// order of the command line. Empty where nothing is swept.
    pub parameters: Arc<[(String, String)]>,
    /// The configuration of its runs, but for the seed.
    pub config: RunConfig,
}

/// What a sweep came to.
#[derive(Clone, Debug)]
pub struct Swept {
    /// The settings, in order: the last swept field changes fastest.
    pub cells: Vec<Cell>,
    /// By cell, then seed, then place in the roster. A shard has those of
    /// its runs alone.
    pub rows: Vec<Row>,
    /// In the order of `rows`. Of a large sweep the first seeds of each cell
    /// have one; see [`Track`].
    pub tracks: Vec<Track>,
}
