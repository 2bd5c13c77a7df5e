//! `{out}` in a participant's command: what a filter writes lies beside the log
//! of its run, live, on a replay, and where the kernel confines it.

use std::fs;
use std::path::Path;

use rusty_tests::*;

const WITNESSES: &str = "[[participant]]\nname = \"logger\"\nrole = \"logger\"\n\
    command = [\"logger\"]\n";

/// A scenario in which a mapper writes where `stem` says.
fn scenario(place: &Path, stem: &str, more: &str) -> String {
    let file = place.join("s.toml");
    let text = format!(
        "name = \"out\"\nticks = 30\n[[participant]]\nname = \"mapper\"\n\
         command = [\"gridmap\", \"--save\", \"{stem}\"]\n{more}{WITNESSES}"
    );
    fs::write(&file, text).unwrap();
    file.to_str().unwrap().to_owned()
}

/// Whether the three files of a map are there.
fn has_map(stem: &Path) -> bool {
    let there: Vec<bool> =
        ["pgm", "yaml", "png"].iter().map(|e| stem.with_extension(e).is_file()).collect();
    assert!(there.iter().all(|t| *t == there[0]), "{there:?} of {}", stem.display());
    there[0]
}

#[test]
fn a_map_lies_beside_its_log_and_a_replay_leaves_it_alone() {
    let place = folder();
    let (first, second) = (place.path().join("a b"), place.path().join("second"));
    let file = scenario(place.path(), "{out}/maps/map", "");
    let _ = launch("out", &first, &[&file]);
    assert!(has_map(&first.join("maps/map")));
    let log = first.join("run.log");
    let log = log.to_str().unwrap();
    // The log says what was written, not where it was.
    let info = sim_server(&["info", log]).expect(0).stdout;
    assert!(info.contains("--save {out}/maps/map"), "{info}");
    let picture = first.join("maps/map.pgm");
    let map = fs::read(&picture).unwrap();
    fs::write(&picture, "mine").unwrap();
    let run = fresh_run("out-again");
    let out = second.to_str().unwrap();
    let args = ["replay", log, "--run", run.as_str(), "--out", out];
    let _ = sim_server(&args).expect(0);
    assert_eq!(fs::read(second.join("maps/map.pgm")).unwrap(), map);
    // To verify is to leave everything as it is.
    let verified = sim_server(&["verify", "--clients", log]).expect(0);
    assert!(verified.stdout.contains("mapper"), "{verified:#?}");
    assert_eq!(fs::read(&picture).unwrap(), b"mine");
}

#[test]
fn one_that_is_added_writes_there_as_well() {
    let place = folder();
    let add = "--add=extra=gridmap --save {out}/extra";
    let _ = launch("out-add", place.path(), &["apartment", add, "--ticks", "30"]);
    assert!(has_map(&place.path().join("extra")));
}

#[test]
fn a_confined_one_has_a_folder_of_its_own_and_no_other() {
    let place = folder();
    let out = place.path().join("run");
    let file = scenario(place.path(), "{out}/map", "sandbox = \"required\"\n");
    let made = sim_server(&["launch", &file, "--out", out.to_str().unwrap()]);
    if made.code == Some(2) && made.stderr.contains("cannot be had") {
        skipped(made.stderr.trim());
        return;
    }
    let _ = made.expect(0);
    assert!(has_map(&out.join("mapper/map")) && !has_map(&out.join("map")));
    // Beside the log, where the run writes, it may not: and it says what it may not.
    let elsewhere = out.join("map").to_str().unwrap().to_owned();
    let file = scenario(place.path(), &elsewhere, "sandbox = \"required\"\n");
    let ended = sim_server(&["launch", &file, "--force", "--out", out.to_str().unwrap()]);
    assert_ne!(ended.code, Some(0));
    let said = format!("{}{}", ended.stdout, ended.stderr);
    assert!(said.contains("map.pgm: Permission denied"), "{said}");
    assert!(!has_map(&out.join("map")));
}
