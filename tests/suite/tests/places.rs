//! Places that cannot be written: a run says which, keeps what it can, or does
//! not start.

mod common;

use std::fs;
use std::path::Path;
use std::process::Command;

use common::*;
use rusty_tests::*;
use serde_json::Value;

/// A disk that can be read and not written. Permission bits would not do: they
/// do not bind everybody.
struct ReadOnlyDisk(tempfile::TempDir);

impl ReadOnlyDisk {
    /// `None`, with a printed reason, where it may not be.
    fn new() -> Option<Self> {
        let place = folder();
        let mount = Command::new("mount")
            .args(["-t", "tmpfs", "-o", "size=200k,ro", "tmpfs"])
            .arg(place.path())
            .output();
        if mount.as_ref().is_ok_and(|m| m.status.success()) {
            return Some(Self(place));
        }
        skipped(&format!("a disk cannot be mounted read-only here: {mount:?}"));
        None
    }

    fn path(&self) -> &str {
        self.0.path().to_str().unwrap()
    }
}

impl Drop for ReadOnlyDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0.path()).status();
    }
}

#[test]
fn a_launch_into_a_place_that_is_read_only_does_not_start_and_names_it() {
    let Some(disk) = ReadOnlyDisk::new() else { return };
    let new = format!("{}/new", disk.path());
    for (out, file) in [(disk.path(), "run.json"), (&new, "")] {
        let run = fresh_run("ro");
        let ended = sim_server(&["launch", "--run", run.as_str(), "--out", out]).expect(1);
        let file = Path::new(out).join(file).display().to_string();
        let words = format!("{}: Read-only file system", file.trim_end_matches('/'));
        assert!(ended.stderr.contains(&words), "{words:?} is not in {}", ended.stderr);
        assert_eq!(participants(&run), []);
        nothing_left(&run);
    }
}

#[test]
fn a_logger_that_cannot_write_is_lost_and_the_others_can_go_on() {
    let Some(disk) = ReadOnlyDisk::new() else { return };
    let live = Live::start("serve", "ro-log", &[&["--ticks", "50"], &GO_ON]);
    let logger = live.join("logger", &["--out", disk.path()]);
    let others = ["dead-reckoning", "score"].map(|name| live.join(name, &[]));
    let logger = logger.wait().expect(1);
    assert!(logger.stderr.contains("run.log: Read-only file system"), "{logger:?}");
    assert!(others.map(|other| other.wait().code) == [Some(0); 2]);
    let after = live.ends_with(3);
    is_lost(&after.report, "logger");
    assert_eq!((&after.report["ended"], &after.report["ticks"]), (&"done".into(), &50.into()));
    assert_eq!(after.report["scores"].as_array().unwrap().len(), 1);
}

/// It alone is lost. One that fails right after it joined may have ended before
/// the server has opened its side of the port on which it said so.
#[track_caller]
fn is_lost(report: &Value, name: &str) {
    let losses = report["losses"].as_array().unwrap();
    assert_eq!((losses.len(), text(&losses[0], "name")), (1, name), "{report}");
    assert!(matches!(text(&losses[0], "kind"), "failed" | "dead"), "{report}");
}

/// A scenario in which `who` finds a folder where it is to write `file`.
fn scenario(place: &Path, who: &str, file: &str) -> String {
    let script = place.join("first.sh");
    fs::write(&script, "mkdir \"$1\" && program=$2 && shift 2 && exec \"$program\" \"$@\"\n")
        .unwrap();
    let apartment = repository().join("sim-server/engine/scenarios/apartment.toml");
    let text = fs::read_to_string(apartment).unwrap();
    let command = |words: &str| format!("command = [{words}]");
    let words = format!("\"sh\", {script:?}, \"{{out}}/{file}\", {:?}", binary(who));
    let changed = text.replace(&command(&format!("{who:?}")), &command(&words));
    assert_ne!(changed, text);
    let path = place.join("s.toml");
    fs::write(&path, changed).unwrap();
    path.to_str().unwrap().to_owned()
}

/// What a run of 50 ticks comes to if a folder lies where this file should be.
fn with_a_folder_in_place_of(file: &str, more: &[&str], code: i32) -> (Value, tempfile::TempDir) {
    let (place, out) = (folder(), folder());
    let who = if file == "run.log" { "logger" } else { "score" };
    let scenario = scenario(place.path(), who, file);
    let args = [&[scenario.as_str(), "--ticks", "50"], more].concat();
    let report = launch_to("taken", out.path(), &args, code);
    assert!(out.path().join(file).is_dir(), "what is not the scorer's stays");
    is_lost(&report, who);
    let said = format!("{}{}", report["losses"], report["remarks"]);
    let words = format!("{}: Is a directory", out.path().join(file).display());
    assert!(said.contains(&words), "{words:?} is not in {said}");
    (report, out)
}

#[test]
fn a_picture_that_cannot_be_written_is_said_and_the_rest_is_kept() {
    for (file, kept) in [
        ("report.png", &["report.svg"][..]),
        ("report.svg", &["report.png"]),
        ("report.html", &["report.svg", "report.png"]),
    ] {
        let (report, out) = with_a_folder_in_place_of(file, &[], 3);
        assert_eq!((&report["ended"], &report["ticks"]), (&"done".into(), &50.into()));
        // Scores and log are as good as ever; what could not be written is not named.
        assert_eq!(report["scores"].as_array().unwrap().len(), 1);
        let path = |file: &str| out.path().join(file).display().to_string();
        let kept: Vec<String> = kept.iter().map(|file| path(file)).collect();
        assert_eq!(report["pictures"], Value::from(kept));
        let page = (file != "report.html").then(|| path("report.html"));
        assert_eq!(report["report"], Value::from(page));
        let log = text(&report, "log");
        let verdict = sim_server(&["verify", "--json", log]).expect(0).json();
        assert_eq!(verdict["digest"], report["digest"]);
    }
}

#[test]
fn scores_that_cannot_be_written_are_said_and_the_log_is_kept() {
    let (report, _out) = with_a_folder_in_place_of("score.json", &[], 3);
    assert_eq!(report["scores"], Value::Array(vec![]));
    assert_eq!(report["scores_file"], Value::Null);
    let verdict = sim_server(&["verify", "--json", text(&report, "log")]).expect(0).json();
    assert_eq!(verdict["digest"], report["digest"]);
}

#[test]
fn a_log_that_cannot_be_written_ends_the_run_or_is_gone_without() {
    let (report, _out) = with_a_folder_in_place_of("run.log", &[], 1);
    assert_eq!(report["ended"], "aborted");
    let (report, _out) = with_a_folder_in_place_of("run.log", &GO_ON, 3);
    assert_eq!((&report["ended"], &report["ticks"]), (&"done".into(), &50.into()));
    assert_eq!(report["scores"].as_array().unwrap().len(), 1);
    // A folder is no log of this run.
    assert_eq!(report["log"], Value::Null);
}
