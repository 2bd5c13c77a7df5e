//! The runs whose folders are in a folder.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use serde::Serialize;

use super::{FolderError, FolderProblem, Marker, is_living, names_in};

/// A run that was found by its folder.
#[derive(Clone, Debug, Serialize)]
pub struct FoundRun {
    /// Name of the folder.
    pub name: String,
    /// Whether its server still runs.
    pub living: bool,
    /// Size of all files in it, bytes.
    pub bytes: u64,
    /// What the folder says of the run.
    #[serde(flatten)]
    pub marker: Marker,
}

impl FoundRun {
    /// living, done, interrupted, aborted, or cut short: without a known end.
    #[must_use]
    pub fn state(&self) -> &str {
        match &self.marker.end {
            _ if self.living => "living",
            Some(end) => &end.ended,
            None => "cut short",
        }
    }
}

/// The runs whose folders are in this one, by name. Links are not followed.
///
/// # Errors
/// [`FolderError`] if the folder is there and cannot be read.
pub fn runs_in(dir: &Path) -> Result<Vec<FoundRun>, FolderError> {
    let names = match names_in(dir) {
        Err(FolderError { problem: FolderProblem::Io(error), .. })
            if error.kind() == ErrorKind::NotFound =>
        {
            Vec::new()
        }
        names => names?,
    };
    let found = names.into_iter().filter_map(|name| {
        let path = dir.join(&name);
        let is_folder = fs::symlink_metadata(&path).is_ok_and(|found| found.is_dir());
        let marker = is_folder.then(|| Marker::of(&path)).flatten()?;
        Some(FoundRun { name, living: is_living(&path), bytes: size_of(&path), marker })
    });
    Ok(found.collect())
}

/// Size of the files in a folder, bytes; of what goes away meanwhile, 0.
fn size_of(folder: &Path) -> u64 {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let sizes = entries.map(|entry| match entry.metadata() {
        Ok(found) if found.is_dir() => size_of(&entry.path()),
        Ok(found) => found.len(),
        Err(_) => 0,
    });
    sizes.sum()
}
