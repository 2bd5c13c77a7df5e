//! Packages of npm, for tests. Where there is no npm, or it finds no packages, tests are
//! skipped with a printed reason.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use crate::binaries;
use crate::python::{or_skipped, run};

/// The client of the protocol of Foxglove, what its apps read messages of ROS 2 with, and
/// a WebSocket for Node before 22.
const PACKAGES: [&str; 4] = [
    "@foxglove/ws-protocol@0.8.0",
    "@foxglove/rosmsg@5.0.5",
    "@foxglove/rosmsg2-serialization@3.1.0",
    "ws@8.18.0",
];

/// The folder below the target folder that holds `node_modules`, made once. `None`, with a
/// printed reason, where that cannot be had.
pub fn packages() -> Option<&'static Path> {
    static PACKAGES: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    or_skipped(PACKAGES.get_or_init(prepare))
}

fn prepare() -> Result<PathBuf, String> {
    let place = binaries().parent().unwrap().join("npm");
    fs::create_dir_all(&place).unwrap();
    // Tests of several processes come here at once.
    let lock = File::create(place.join("lock")).unwrap();
    lock.lock().unwrap();
    let (ready, text) = (place.join("ready"), PACKAGES.join(" "));
    if fs::read_to_string(&ready).is_ok_and(|made| made == text) {
        return Ok(place);
    }
    let mut npm = Command::new("npm");
    npm.args(["install", "--silent", "--no-audit", "--no-fund", "--ignore-scripts"]);
    // Where nothing answers, npm would try for more than eight minutes.
    npm.args(["--fetch-timeout=30000", "--fetch-retries=1", "--prefix"]);
    run(npm.arg(&place).args(PACKAGES))?;
    fs::write(ready, text).unwrap();
    Ok(place)
}
