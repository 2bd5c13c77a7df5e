//! A Python with Ray in it, for tests. Where pip does not find this version, tests are
//! skipped with a printed reason.

use std::path::PathBuf;
use std::process::Command;
use std::sync::OnceLock;

use crate::Folder;
use crate::python::{environment, or_skipped, run, with_ours};

/// The version that sweeps are tested with.
const PACKAGE: &str = "ray==2.60.0";

/// A command of a Python with Ray and our package, which leaves nothing outside `place`.
/// `None`, with a printed reason, where there is no Ray, or no package of ours.
pub fn ray(place: &Folder) -> Option<Command> {
    static PYTHON: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    let prepare = || environment("ray", ("ready", PACKAGE), "import ray", &[&[PACKAGE]], run);
    let mut command = with_ours(or_skipped(PYTHON.get_or_init(prepare))?)?;
    command.env("RAY_USAGE_STATS_ENABLED", "0");
    // Ray writes a token there.
    command.env("HOME", place.path()).env("RAY_ADDRESS", "local");
    Some(command)
}
