//! The parts of all shards as one sweep.

use std::path::Path;

use rusty_engine::shell;

use super::cell::Swept;
use super::error::SweepError;
use super::incomplete::Incomplete;
use super::job::swept;
use super::manifest::Manifest;
use super::plan::Plan;

/// Reads the parts of all shards in `folder`. Returns rows and tracks as the sweep in
/// one process has them, and the runs in which something was lost: seed and what.
///
/// # Errors
/// [`SweepError::Incomplete`] names the shards that have no whole part, and the command
/// that makes them. `path` is that of the manifest.
pub fn merge(
    manifest: &Manifest,
    path: &Path,
    plan: &Plan,
    folder: &Path,
) -> Result<(Swept, Vec<(u64, String)>), SweepError> {
    let (mut records, mut faults) = (Vec::new(), Vec::new());
    for index in 0..manifest.shards {
        let part = manifest.part(folder, index)?;
        match part.read() {
            Ok(of_shard) => records.extend(of_shard),
            Err(fault) => faults.push((index, format!("{} {fault}", part.path.display()))),
        }
    }
    if faults.is_empty() {
        return Ok(swept(plan, records));
    }
    let [path, folder] = [path, folder].map(Path::to_string_lossy);
    let [path, folder] = [&path, &folder].map(|word| shell::quoted(word));
    let command = format!("sim-server sweep run {path} --shard I --out {folder}");
    Err(SweepError::Incomplete(Incomplete { shards: manifest.shards, faults, command }))
}
