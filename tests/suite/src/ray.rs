//! A Python with Ray in it, for tests. Where pip does not find this version, tests are
//! skipped with a printed reason.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use crate::python::{environment, or_skipped, run};
use crate::{Folder, binaries};

/// The version that sweeps are tested with.
const PACKAGE: &str = "ray==2.60.0";

/// A command of a Python with Ray and our package, which leaves nothing outside `place`.
/// `None`, with a printed reason, where there is no Ray, or no package of ours.
pub fn ray(place: &Folder) -> Option<Command> {
    static PYTHON: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    let ours = crate::python::python()?;
    let python = or_skipped(PYTHON.get_or_init(prepare))?;
    let find = "import sysconfig; print(sysconfig.get_path('platlib'))";
    let packages = run(Command::new(ours).args(["-c", find])).unwrap();
    let mut command = Command::new(python);
    command.env("PYTHONPATH", packages.trim()).env("RAY_USAGE_STATS_ENABLED", "0");
    // Ray writes a token there.
    command.env("HOME", place.path()).env("RAY_ADDRESS", "local");
    Some(command)
}

fn prepare() -> Result<PathBuf, String> {
    let place: &Path = &binaries().parent().unwrap().join("ray");
    fs::create_dir_all(place).unwrap();
    // Tests of several processes come here at once.
    let lock = File::create(place.join("lock")).unwrap();
    lock.lock().unwrap();
    environment(place, ("ready", PACKAGE), "import ray", &[&[PACKAGE]], run)
}
