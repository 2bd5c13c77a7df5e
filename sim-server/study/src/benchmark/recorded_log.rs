//! `RecordedLog`: a recording of a robot, as a result names it.

use serde::{Deserialize, Serialize};

/// Name of the scenario of all recordings.
pub const RECORDINGS: &str = "recordings";

/// A log, as a result names it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordedLog {
    /// Name of the file, without its extension.
    pub name: String,
    /// Digest of its bytes (XXH3, 128 bits), 32 hexadecimal digits.
    pub digest: String,
}
