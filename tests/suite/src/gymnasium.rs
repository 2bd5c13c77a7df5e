//! A Python with Gymnasium in it, for tests. Where pip does not find this version, tests
//! are skipped with a printed reason.

use std::path::PathBuf;
use std::process::Command;
use std::sync::OnceLock;

use crate::python::{environment, or_skipped, run, with_ours};

/// The version that the environments are tested with.
const PACKAGE: &str = "gymnasium==1.4.0";

/// A command of a Python with Gymnasium and our package. `None`, with a printed reason,
/// where one of them cannot be had.
pub fn gymnasium() -> Option<Command> {
    static PYTHON: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    let prepare =
        || environment("gymnasium", ("ready", PACKAGE), "import gymnasium", &[&[PACKAGE]], run);
    with_ours(or_skipped(PYTHON.get_or_init(prepare))?)
}
