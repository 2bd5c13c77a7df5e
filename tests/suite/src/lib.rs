//! What tests that span processes share: the real binaries, runs with separate
//! names, a watchdog, and a look at what was left behind.
//!
//! A test never asserts on wall time. The watchdog ends what hangs, and the
//! test then fails with everything the run had printed.

#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

pub mod browser;
pub mod counts;
mod dice;
mod documents;
pub mod evo;
pub mod fuzz;
mod guard;
pub mod gymnasium;
pub mod hand;
mod live;
mod logs;
pub mod npm;
mod process;
mod processes;
pub mod python;
pub mod ray;
pub mod ros;
mod scenarios;
pub mod viewed;

pub use dice::{Dice, cases};
pub use documents::*;
pub use guard::*;
pub use live::*;
pub use logs::*;
pub use process::*;
pub use processes::*;
pub use scenarios::*;

// What nearly every test names.
pub use std::fs;
pub use std::path::{Path, PathBuf};
pub use std::process::Command;
pub use std::time::Duration;

pub use rustix::process::Signal;
pub use rusty_contract::log::TickRecord;
pub use rusty_contract::{LogHeader, Reply, RunName};
pub use rusty_geometry::SE2;
pub use rusty_link::Domain;
pub use serde_json::{Value, json};

use std::io::Write as _;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

use rusty_contract::Credentials;
use tempfile::TempDir;

/// After this long a process counts as hanging.
pub const WATCHDOG: Duration = Duration::from_secs(120);

/// The root of the repository.
pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// Real logs and maps next to the repository on some machines. `None`,
/// with a printed reason, where they do not.
pub fn real_data(file: &str) -> Option<PathBuf> {
    let path = repository().join("../shared/data").join(file);
    if path.exists() {
        return Some(path);
    }
    skipped(&format!("{} is not on this machine", path.display()));
    None
}

/// Prints that a test is skipped, and why, past what captures the output of tests
/// that pass.
pub fn skipped(reason: &str) {
    let thread = std::thread::current();
    let line = format!("\nskipped: {}: {reason}\n", thread.name().unwrap_or("a test"));
    let _ = std::io::stderr().write_all(line.as_bytes());
}

/// The folder of the binaries under test, built once per test process.
/// `cargo test` builds no binaries of other packages; this does, in the
/// profile of the tests.
pub fn binaries() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let exe = std::env::current_exe().unwrap();
        let deps = exe.parent().unwrap();
        let folder = if deps.ends_with("deps") { deps.parent().unwrap() } else { deps };
        let mut build = Command::new(env!("CARGO"));
        build.current_dir(repository()).args(["build", "--quiet", "--bins", "--examples"]);
        build.args(["-p", "sim-server", "-p", "rusty-clients"]);
        build.args(["-p", "rusty-widgets", "-p", "rusty-tests"]);
        // With it other crates are built with the features that the whole
        // workspace gives them: those of `cargo test --workspace`.
        build.args(["--lib", "-p", "rusty-python", "-p", "rusty-gym"]);
        build.arg("--target-dir").arg(folder.parent().unwrap());
        if folder.ends_with("release") {
            build.arg("--release");
        }
        assert!(build.status().unwrap().success(), "the binaries do not build");
        folder.to_owned()
    })
}

/// A path to a binary or example.
pub fn binary(name: &str) -> PathBuf {
    let folder = binaries();
    let beside = folder.join(name);
    if beside.exists() { beside } else { folder.join("examples").join(name) }
}

/// The credentials on this process's standard input, if they are there.
pub fn credentials(on_stdin: bool) -> Option<Credentials> {
    let read = || std::io::read_to_string(std::io::stdin()).unwrap();
    on_stdin.then(|| Credentials::from_text(&read()).unwrap())
}

/// A run name that no other test has.
pub fn fresh_run(tag: &str) -> RunName {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let n = COUNT.fetch_add(1, Ordering::Relaxed);
    RunName::new(&format!("t{}-{n}-{tag}", std::process::id())).unwrap()
}

/// A path as an argument.
#[track_caller]
pub fn arg(path: &(impl AsRef<Path> + ?Sized)) -> &str {
    path.as_ref().to_str().unwrap()
}

/// A folder that goes when it is dropped.
pub struct Folder(TempDir);

pub fn folder() -> Folder {
    Folder(tempfile::tempdir().unwrap())
}

impl Folder {
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// The path of a file in it.
    pub fn at(&self, name: impl AsRef<Path>) -> PathBuf {
        self.path().join(name)
    }

    /// Writes a file in it, and returns its path.
    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) -> String {
        write(self.path(), name, text)
    }
}

/// Waits under the watchdog until `done` says so.
#[track_caller]
pub fn until(what: &str, done: impl FnMut() -> bool) {
    until_within(WATCHDOG, what, done);
}

/// The same under a shorter one.
#[track_caller]
pub fn until_within(limit: Duration, what: &str, mut done: impl FnMut() -> bool) {
    let deadline = Instant::now() + limit;
    while !done() {
        assert!(Instant::now() < deadline, "{what}: never happened");
        std::thread::sleep(Duration::from_millis(2));
    }
}
