//! Places that cannot be written: a run says which, keeps what it can, or does
//! not start.

use rusty_tests::*;

#[test]
fn a_launch_into_a_place_that_is_read_only_does_not_start_and_names_it() {
    let Some(disk) = Disk::mount(",ro") else { return };
    let new = format!("{}/new", arg(disk.0.path()));
    for (out, file) in [(arg(disk.0.path()), "run.json"), (&new, "")] {
        let ended = run_to("ro", Path::new(out), &["launch"]).expect(1);
        let file = Path::new(out).join(file).display().to_string();
        ended.says(&format!("{}: ", file.trim_end_matches('/'))).says("Read-only file system");
    }
}

#[test]
fn a_logger_that_cannot_write_is_lost_and_the_others_can_go_on() {
    let Some(disk) = Disk::mount(",ro") else { return };
    let live = Live::start("serve", "ro-log", &[&["--ticks", "50"], &GO_ON]);
    let logger = live.join("logger", &["--out", arg(disk.0.path())]);
    let others = ["dead-reckoning", "score"].map(|name| live.join(name, &[]));
    let logger = logger.wait().expect(1);
    logger.says("run.log: cannot be written: Read-only file system");
    assert!(others.map(|other| other.wait().code) == [Some(0); 2]);
    let after = live.ends_with(3);
    is_lost(&after.report, "logger");
    after.ended("done", 50);
    assert_eq!(list(&after.report, "scores").len(), 1);
}

/// It alone is lost. One that fails right after it joined may have ended before
/// the server has opened its side of the port on which it said so.
#[track_caller]
fn is_lost(report: &Value, name: &str) {
    let losses = list(report, "losses");
    assert_eq!((losses.len(), text(&losses[0], "name")), (1, name), "{report}");
    assert!(matches!(text(&losses[0], "kind"), "failed" | "dead"), "{report}");
}

/// A scenario in which `who` finds a folder where it is to write `file`.
fn scenario(place: &Path, who: &str, file: &str) -> String {
    let script = "mkdir \"$1\" && program=$2 && shift 2 && exec \"$program\" \"$@\"\n";
    let script = write(place, "first.sh", script);
    let text = apartment_scenario();
    let command = |words: &str| format!("command = [{words}]");
    let words = format!("\"sh\", {script:?}, \"{{out}}/{file}\", {:?}", binary(who));
    let changed = text.replace(&command(&format!("{who:?}")), &command(&words));
    assert_ne!(changed, text);
    write(place, "s.toml", changed)
}

/// What a run of 50 ticks comes to if a folder lies where this file should be.
fn with_a_folder_in_place_of(file: &str, more: &[&str], code: i32) -> (Value, Folder) {
    let (place, out) = (folder(), folder());
    let who = if file == "run.log" { "logger" } else { "score" };
    let scenario = scenario(place.path(), who, file);
    let args = [&[scenario.as_str(), "--ticks", "50"], more].concat();
    let report = launch_to("taken", out.path(), &args, code);
    assert!(out.at(file).is_dir(), "what is not the scorer's stays");
    is_lost(&report, who);
    let said = format!("{}{}", report["losses"], report["remarks"]);
    let words = format!("{}: cannot be written: Is a directory", out.at(file).display());
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
        assert_eq!(list(&report, "scores").len(), 1);
        let path = |file: &str| out.at(file).display().to_string();
        let kept: Vec<String> = kept.iter().map(|file| path(file)).collect();
        assert_eq!(report["pictures"], Value::from(kept));
        let page = (file != "report.html").then(|| path("report.html"));
        assert_eq!(report["report"], Value::from(page));
        let verdict = about("verify", &log_of(&report), &["--json"]).expect(0).json();
        assert_eq!(verdict["digest"], report["digest"]);
    }
}

#[test]
fn scores_that_cannot_be_written_are_said_and_the_log_is_kept() {
    let (report, _out) = with_a_folder_in_place_of("score.json", &[], 3);
    assert_eq!(report["scores"], json!([]));
    assert_eq!(report["scores_file"], Value::Null);
    let verdict = about("verify", &log_of(&report), &["--json"]).expect(0).json();
    assert_eq!(verdict["digest"], report["digest"]);
}

#[test]
fn a_log_that_cannot_be_written_ends_the_run_or_is_gone_without() {
    let (report, _out) = with_a_folder_in_place_of("run.log", &[], 1);
    assert_eq!(report["ended"], "aborted");
    let (report, _out) = with_a_folder_in_place_of("run.log", &GO_ON, 3);
    assert_eq!((&report["ended"], &report["ticks"]), (&"done".into(), &50.into()));
    assert_eq!(list(&report, "scores").len(), 1);
    // A folder is no log of this run.
    assert_eq!(report["log"], Value::Null);
}
