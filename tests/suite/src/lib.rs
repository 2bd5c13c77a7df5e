//! What tests that span processes share: the real binaries, runs with names of
//! their own, a watchdog, and a look at what was left behind.
//!
//! A test never asserts on wall time. The watchdog ends what hangs, and the
//! test then fails with everything the run had printed.

#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

pub mod browser;
pub mod counts;
mod dice;
pub mod evo;
pub mod fuzz;
pub mod python;

pub use dice::{Dice, cases};

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use rusty_contract::{Credentials, RunName};
use rusty_link::Domain;
use serde_json::Value;

/// After this long a process counts as hanging.
pub const WATCHDOG: Duration = Duration::from_secs(120);

/// The root of the repository.
pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// A scenario of the filters, by the name of its file.
pub fn filter_scenario(name: &str) -> String {
    repository().join("clients/filters/scenarios").join(name).to_str().unwrap().to_owned()
}

/// Root mean square and 95th percentile of distances.
pub fn spread(mut distances_m: Vec<f64>) -> (f64, f64) {
    distances_m.sort_by(f64::total_cmp);
    let count = distances_m.len();
    let squares: f64 = distances_m.iter().map(|d| d * d).sum();
    ((squares / count as f64).sqrt(), distances_m[count * 95 / 100])
}

/// Real logs and maps that lie beside the repository on some machines. `None`,
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
        build.args(["-p", "sim-server", "-p", "rusty-clients", "-p", "rusty-filters"]);
        build.args(["-p", "rusty-logger", "-p", "rusty-scorer"]);
        build.args(["-p", "rusty-tests"]);
        // With it other crates are built with the features that the whole
        // workspace gives them: those of `cargo test --workspace`.
        build.args(["--lib", "-p", "rusty-python"]);
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

/// A folder that goes when it is dropped.
pub fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

/// What a process left when it ended.
#[derive(Debug)]
pub struct Ended {
    /// Exit code; `None` if a signal ended it.
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Ended {
    /// The JSON document on stdout.
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.stdout)
            .unwrap_or_else(|e| panic!("stdout is no JSON document ({e}):\n{self:#?}"))
    }

    /// Fails the test unless the exit code is this one.
    #[track_caller]
    pub fn expect(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{self:#?}");
        self
    }
}

/// A process with a watchdog. Dropped, it is killed.
pub struct Process {
    child: Child,
    stdout: std::thread::JoinHandle<String>,
    stderr: std::thread::JoinHandle<String>,
    what: String,
}

fn collect(mut pipe: impl std::io::Read + Send + 'static) -> std::thread::JoinHandle<String> {
    std::thread::spawn(move || {
        let mut text = Vec::new();
        let _ = pipe.read_to_end(&mut text);
        String::from_utf8_lossy(&text).into_owned()
    })
}

impl Process {
    /// Starts a program of ours.
    pub fn start(program: &str, args: &[&str]) -> Self {
        Self::spawn(Command::new(binary(program)).args(args))
    }

    /// Starts any command.
    pub fn spawn(command: &mut Command) -> Self {
        let what = format!("{command:?}");
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap_or_else(|e| panic!("{what}: {e}"));
        let stdout = collect(child.stdout.take().unwrap());
        let stderr = collect(child.stderr.take().unwrap());
        Self { child, stdout, stderr, what }
    }

    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Sends a signal.
    pub fn signal(&self, signal: rustix::process::Signal) {
        send_signal(self.pid(), signal);
    }

    /// Waits for the end, under the watchdog.
    #[track_caller]
    pub fn wait(self) -> Ended {
        self.wait_within(WATCHDOG)
    }

    /// The same under a shorter one: for what must not come about by a timeout
    /// of the run.
    #[track_caller]
    pub fn wait_within(mut self, limit: Duration) -> Ended {
        let deadline = Instant::now() + limit;
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            if Instant::now() > deadline {
                let _ = self.child.kill();
                let _ = self.child.wait();
                let (out, err) = (self.stdout.join().unwrap(), self.stderr.join().unwrap());
                panic!("{} hangs.\nstdout: {out}\nstderr: {err}", self.what);
            }
            std::thread::sleep(Duration::from_millis(2));
        };
        let (stdout, stderr) = (self.stdout.join().unwrap(), self.stderr.join().unwrap());
        Ended { code: status.code(), stdout, stderr }
    }
}

/// Sends a signal to a process.
pub fn send_signal(pid: u32, signal: rustix::process::Signal) {
    let pid = rustix::process::Pid::from_raw(pid as i32).unwrap();
    let _ = rustix::process::kill_process(pid, signal);
}

/// Runs `sim-server` to its end.
#[track_caller]
pub fn sim_server(args: &[&str]) -> Ended {
    Process::start("sim-server", args).wait()
}

/// A whole run by `launch --json` in a folder of its own, exit code 0
/// expected; fails if it leaves anything behind.
#[track_caller]
pub fn launch(tag: &str, out: &Path, args: &[&str]) -> Value {
    launch_to(tag, out, args, 0)
}

/// The same, with another exit code expected. A run that was in the folder before
/// is replaced.
#[track_caller]
pub fn launch_to(tag: &str, out: &Path, args: &[&str], code: i32) -> Value {
    let run = fresh_run(tag);
    let mut all = vec!["launch"];
    all.extend_from_slice(args);
    all.extend(["--json", "--force", "--run", run.as_str(), "--out", out.to_str().unwrap()]);
    let ended = sim_server(&all).expect(code);
    nothing_left(&run);
    ended.json()
}

/// Fails if the run has left anything in shared memory or its folder. Another
/// server that starts, or `clean`, sweeps beside it: one that looks at a folder
/// in the moment in which it goes makes it once more, takes its lock, and
/// removes it. What is still there after that was left.
#[track_caller]
pub fn nothing_left(run: &RunName) {
    const SWEEPER: Duration = Duration::from_secs(5);
    let deadline = Instant::now() + SWEEPER;
    loop {
        let traces = Domain::traces(run);
        if traces.is_empty() {
            return;
        }
        assert!(Instant::now() < deadline, "left behind: {traces:?}");
        std::thread::sleep(Duration::from_millis(2));
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

/// Text of a JSON value that must be a string.
#[track_caller]
pub fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or_else(|| panic!("{key} is no text in {value}"))
}

/// Scores, but for how long answers took, which is another time in every run.
#[track_caller]
pub fn timeless(scores: &Value) -> Value {
    let mut scores = scores.clone();
    let list = scores.as_array_mut().unwrap_or_else(|| panic!("no list of scores"));
    list.iter_mut().for_each(|score| score["compute"] = Value::Null);
    scores
}
