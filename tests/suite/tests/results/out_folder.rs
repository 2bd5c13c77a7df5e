//! `{out}` in a participant's command: what a filter writes is next to the log
//! of its run, live, on a replay, and where the kernel confines it.

use rusty_tests::*;

/// A scenario in which a mapper writes where `stem` says.
fn scenario(place: &Path, stem: &str, more: &str) -> String {
    let mapper = estimator("mapper", &["gridmap", "--save", stem], more);
    write(
        place,
        "s.toml",
        format!(
            "name = \"out\"
ticks = 30
{mapper}{RECORDERS}"
        ),
    )
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
    let (first, second) = (place.at("a b"), place.at("second"));
    let file = scenario(place.path(), "{out}/maps/map", "");
    let _ = launch("out", &first, &[&file]);
    assert!(has_map(&first.join("maps/map")));
    let log = first.join("run.log");
    // The log says what was written, not where it was.
    about("info", &log, &[]).expect(0).prints("--save {out}/maps/map");
    let picture = first.join("maps/map.pgm");
    let map = fs::read(&picture).unwrap();
    fs::write(&picture, "mine").unwrap();
    let _ = replay(&log, &second, &[]).expect(0);
    assert_eq!(fs::read(second.join("maps/map.pgm")).unwrap(), map);
    // To verify is to leave everything as it is.
    about("verify", &log, &["--clients"]).expect(0).prints("mapper");
    assert_eq!(fs::read(&picture).unwrap(), b"mine");
}

#[test]
fn one_that_is_added_writes_there_as_well() {
    let place = folder();
    let add = "--add=extra=gridmap --save {out}/extra";
    let _ = launch("out-add", place.path(), &["apartment", add, "--ticks", "30"]);
    assert!(has_map(&place.at("extra")));
}

#[test]
fn a_confined_one_has_a_folder_of_its_own_and_no_other() {
    let place = folder();
    let out = place.at("run");
    let file = scenario(place.path(), "{out}/map", "sandbox = \"required\"\n");
    let made = sim_server(&["launch", &file, "--out", arg(&out)]);
    if made.code == Some(2) && made.stderr.contains("cannot be had") {
        skipped(made.stderr.trim());
        return;
    }
    let _ = made.expect(0);
    assert!(has_map(&out.join("mapper/map")) && !has_map(&out.join("map")));
    // Next to the log, where the run writes, it may not: and it says what it may not.
    let elsewhere = arg(&out.join("map")).to_owned();
    let file = scenario(place.path(), &elsewhere, "sandbox = \"required\"\n");
    let ended = sim_server(&["launch", &file, "--force", "--out", arg(&out)]);
    assert_ne!(ended.code, Some(0));
    let said = format!("{}{}", ended.stdout, ended.stderr);
    assert!(said.contains("map.pgm: cannot be written: Permission denied"), "{said}");
    assert!(!has_map(&out.join("map")));
}
