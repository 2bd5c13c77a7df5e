//! The whole program: every contender makes the same run, and nothing is left.

#![allow(clippy::unwrap_used)] // in a test's helpers, too, a panic is the failure

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

const PROGRAM: &str = env!("CARGO_BIN_EXE_rusty-peers");
const PATIENCE: Duration = Duration::from_secs(300);

fn start(args: &[&str], temp: &Path) -> Child {
    Command::new(PROGRAM)
        .args(args)
        .env("TMPDIR", temp)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Its end; one that does not end is killed and fails.
fn end(mut child: Child) -> Output {
    let began = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if began.elapsed() > PATIENCE {
            child.kill().unwrap();
            panic!("it did not end");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.wait_with_output().unwrap()
}

/// Command lines of living processes that name `temp`, and files in it.
fn left_in(temp: &Path) -> Vec<String> {
    let mut left: Vec<String> = fs::read_dir(temp)
        .unwrap()
        .map(|entry| entry.unwrap().path().display().to_string())
        .collect();
    for process in fs::read_dir("/proc").unwrap().flatten() {
        let words = fs::read(process.path().join("cmdline")).unwrap_or_default();
        let words = String::from_utf8_lossy(&words).replace('\0', " ");
        if words.contains(&*temp.to_string_lossy()) {
            left.push(words);
        }
    }
    left
}

/// Files of Zenoh's shared memory. Other programs on this machine may have some
/// of theirs, so only what is new counts.
fn shared_memory() -> BTreeSet<String> {
    fs::read_dir("/dev/shm")
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|name| name.ends_with(".zenoh"))
        .collect()
}

/// One test for all: what is in shared memory belongs to the whole machine.
#[test]
fn everyone_makes_the_same_run_and_an_interrupted_tour_leaves_nothing() {
    let temp = tempfile::tempdir().unwrap();
    let before = shared_memory();

    let args = [
        "--clients=2",
        "--ticks=200",
        "--warm-up=20",
        "--repetitions=1",
        "--json",
        "--accept-noise",
    ];
    let output = end(start(&args, temp.path()));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{said}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = report["results"]["rows"].as_array().unwrap();
    let absent = report["results"]["facts"]["absent"].as_array().unwrap();
    assert_eq!(rows.len() + 2 * absent.len(), 12, "{report:#}");
    let digest = &rows[0]["digests"];
    assert_eq!(digest.as_str().unwrap().len(), 32);
    for row in rows {
        assert_eq!(row["count"], 200, "{row:#}");
        let makes_runs = row["contender"] != "raw";
        assert!(!makes_runs || &row["digests"] == digest, "{row:#}");
        assert!(row["times_ours"].as_f64().unwrap() > 0.0, "{row:#}");
        assert!(row["cpu_ns_per_tick"].as_f64().unwrap() > 0.0, "{row:#}");
    }
    assert_eq!(left_in(temp.path()), [""; 0]);
    assert_eq!(shared_memory().difference(&before).count(), 0);

    for signals in 1..=2 {
        let args = ["--clients=2", "--ticks=10000000", "--repetitions=1"];
        let child = start(&args, temp.path());
        let began = Instant::now();
        // Until a server has its clients, or at least something lies there.
        while left_in(temp.path()).len() < 4 && began.elapsed() < PATIENCE {
            std::thread::sleep(Duration::from_millis(20));
        }
        let pid = rustix::process::Pid::from_child(&child);
        for _ in 0..signals {
            rustix::process::kill_process(pid, rustix::process::Signal::INT).unwrap();
        }
        let output = end(child);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(3), "{said}");
        assert!(said.contains("interrupted"), "{said}");
        assert_eq!(left_in(temp.path()), [""; 0], "after {signals} signals");
        assert_eq!(shared_memory().difference(&before).count(), 0);
    }
}

#[test]
fn help_teaches_and_nonsense_is_refused() {
    let temp = tempfile::tempdir().unwrap();
    let help = end(start(&["--help"], temp.path()));
    let text = String::from_utf8_lossy(&help.stdout).into_owned();
    assert!(text.contains("Ways of waiting") && text.contains("Exit codes"), "{text}");
    assert!(!text.contains("dead-reckoning"), "{text}");
    for args in [["--clients=0"], ["--peers=carrier-pigeon"], ["--ticks=none"]] {
        assert_eq!(end(start(&args, temp.path())).status.code(), Some(2), "{args:?}");
    }
}
