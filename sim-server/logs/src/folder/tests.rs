//! Tests of the folders of runs.

use super::*;
use rusty_contract::log::{LogWriter, Source};
use rusty_contract::{LogHeader, Participant, Role};

fn header() -> LogHeader {
    let scenario = rusty_engine::scenario_file::load("apartment", &[]).unwrap();
    let mut mapper = Participant::new("mapper", Role::Estimator);
    mapper.command = ["gridmap", "--save", "{out}/maps/map", "--poses={out}/poses.csv", "{out}"]
        .map(str::to_owned)
        .to_vec();
    LogHeader {
        writer: "test".to_owned(),
        source: Source::Simulated,
        config: scenario.config().unwrap(),
        roster: vec![mapper],
        on_loss: scenario.scenario.on_loss,
    }
}

/// A run that was here and is over.
fn a_run(path: &Path) {
    let mut folder = FreeFolder::check(path, false, &[]).unwrap().take(marker()).unwrap();
    folder.begin();
    let end = RunEnd { ended: "done".to_owned(), ticks: 7, digest: "d".to_owned() };
    folder.end(end).unwrap();
}

fn marker() -> Marker {
    Marker::new("lab", &header())
}

fn check(path: &Path, force: bool) -> Result<FreeFolder, FolderError> {
    FreeFolder::check(path, force, &[])
}

#[test]
fn a_folder_holds_one_run_and_is_replaced_as_a_whole() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("a/lab");
    a_run(&path);
    fs::write(path.join("score.json"), "old").unwrap();
    assert!(
        matches!(check(&path, false), Err(FolderError { problem: FolderProblem::HoldsRun(run), .. }) if run == "lab")
    );
    assert_eq!(fs::read(path.join("score.json")).unwrap(), b"old");
    let free = check(&path, true).unwrap();
    assert!(path.join("score.json").exists(), "looking removes nothing");
    let folder = free.take(marker()).unwrap();
    assert_eq!(names_in(&path).unwrap(), ["run.json"]);
    // Its lock is held for as long as the run lasts.
    for force in [false, true] {
        assert!(matches!(
            check(&path, force),
            Err(FolderError { problem: FolderProblem::InUse(_), .. })
        ));
    }
    assert!(runs_in(place.path().join("a").as_path()).unwrap()[0].living);
    drop(folder);
    assert!(path.exists() && names_in(&path).unwrap().is_empty(), "never begun: as it was");
    check(&path, false).unwrap();
}

#[test]
fn two_that_find_a_folder_free_do_not_both_take_it() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("lab");
    let [first, second] = [(); 2].map(|()| check(&path, false).unwrap());
    let _taken = first.take(marker()).unwrap();
    assert!(matches!(
        second.take(marker()),
        Err(FolderError { problem: FolderProblem::InUse(_), .. })
    ));
    assert!(path.join("run.json").exists());
}

#[test]
fn what_no_run_wrote_is_never_removed() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("lab");
    a_run(&path);
    let partial = ".score.json.7.partial";
    for file in ["mapper.txt", "mapper", "maps", "poses.csv", "poses.csv.gz", "run.log", partial] {
        fs::write(path.join(file), "").unwrap();
        check(&path, true).unwrap();
    }
    for file in ["notes", "mapping.txt", "report.docx", "mapper.rs", ".hidden", ".a.7.partial"] {
        fs::write(path.join(file), "mine").unwrap();
        let refused = check(&path, true).err();
        assert!(
            matches!(refused, Some(FolderError { problem: FolderProblem::Foreign(f), .. }) if f == file)
        );
        assert!(OldRun::open(&path).is_err());
        fs::remove_file(path.join(file)).unwrap();
    }
    // A folder without a run, whatever its files are called.
    let other = place.path().join("other");
    fs::create_dir(&other).unwrap();
    check(&other, false).unwrap();
    fs::write(other.join("run.json"), "{}").unwrap();
    for force in [false, true] {
        assert!(matches!(
            check(&other, force),
            Err(FolderError { problem: FolderProblem::Foreign(_), .. })
        ));
    }
    assert!(matches!(
        check(&other.join("run.json"), true),
        Err(FolderError { problem: FolderProblem::NotAFolder, .. })
    ));
}

#[test]
fn a_log_that_is_read_stays_whatever_is_forced() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("lab");
    a_run(&path);
    let log = path.join("run.log");
    fs::write(&log, "").unwrap();
    std::os::unix::fs::symlink(&path, place.path().join("link")).unwrap();
    for (folder, force) in [(path.clone(), false), (path, true), (place.path().join("link"), true)]
    {
        let refused = FreeFolder::check(&folder, force, &[Path::new("other.log"), &log]);
        assert!(matches!(refused, Err(FolderError { problem: FolderProblem::HoldsLog(_), .. })));
    }
}

#[test]
fn runs_are_found_also_without_a_marker_or_an_end() {
    let place = tempfile::tempdir().unwrap();
    a_run(&place.path().join("over"));
    let old = place.path().join("old");
    fs::create_dir(&old).unwrap();
    drop(LogWriter::create(&old.join("run.log"), &header()).unwrap());
    fs::write(old.join("mapper.txt"), "12345").unwrap();
    fs::create_dir(place.path().join("mine")).unwrap();
    std::os::unix::fs::symlink(&old, place.path().join("link")).unwrap();
    let found = runs_in(place.path()).unwrap();
    let seen: Vec<_> = found.iter().map(|run| (run.name.as_str(), run.state())).collect();
    assert_eq!(seen, [("old", "cut short"), ("over", "done")]);
    assert_eq!(found[0].marker.seed, header().seed());
    assert_eq!(found[1].marker.end.as_ref().map(|end| end.ticks), Some(7));
    let log_bytes = fs::metadata(old.join("run.log")).unwrap().len();
    assert_eq!(found[0].bytes, log_bytes + 5);
    OldRun::open(&old).unwrap().remove().unwrap();
    assert!(!old.exists() && runs_in(&place.path().join("gone")).unwrap().is_empty());
}

#[test]
fn a_link_in_a_folder_is_removed_and_not_followed() {
    let place = tempfile::tempdir().unwrap();
    let (path, mine) = (place.path().join("lab"), place.path().join("mine"));
    a_run(&path);
    fs::create_dir(&mine).unwrap();
    fs::write(mine.join("file"), "").unwrap();
    std::os::unix::fs::symlink(&mine, path.join("maps")).unwrap();
    OldRun::open(&path).unwrap().remove().unwrap();
    assert!(!path.exists() && mine.join("file").exists());
}
