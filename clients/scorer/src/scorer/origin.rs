//! `Origin`: when a run was started and by which command, from the `run.json` that the
//! server writes into the run's folder.

use std::path::Path;

use rusty_contract::input;
use serde::Deserialize;

use crate::scoring::trace::Origin;

#[derive(Deserialize)]
struct Marker {
    #[serde(default)]
    started_utc: String,
    #[serde(default)]
    command: String,
    end: Option<End>,
}

#[derive(Deserialize)]
struct End {
    digest: String,
}

/// Returns the origin of the run with this digest, if `folder` is the folder of that run.
/// Any process of this user can write into the file: the report only shows what it has.
pub(super) fn of(folder: &Path, digest: &str) -> Option<Origin> {
    let json = input::read(&folder.join("run.json")).ok()?;
    let Marker { started_utc, command, end } = serde_json::from_slice(&json).ok()?;
    // While the run lasts it has no end.
    let is_it = end.is_none_or(|end| end.digest == digest) && !started_utc.is_empty();
    is_it.then_some(Origin { started_utc, command })
}
