//! Forks: a run again up to a tick, to the bit, and another from there on.

use std::fs;
use std::path::{Path, PathBuf};

use rusty_contract::log::{LogReader, Read, TickRecord};
use rusty_tests::{Ended, folder, fresh_run, launch, nothing_left, sim_server, text, timeless};
use serde_json::Value;

const TICKS: usize = 120;
const AT: usize = 60;

fn path(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn load(log: &Path) -> Vec<TickRecord> {
    let mut reader = LogReader::open(log).unwrap();
    let mut records = Vec::new();
    while let Read::Tick(entry) = reader.read().unwrap() {
        records.push(entry.record);
    }
    records
}

fn fork(log: &Path, out: &Path, args: &[&str]) -> Ended {
    let run = fresh_run("fork");
    let all = ["fork", path(log), "--json", "--run", run.as_str(), "--out", path(out)];
    let ended = sim_server(&[&all, args].concat());
    nothing_left(&run);
    ended
}

/// A run, and branches of it.
struct Tree {
    place: tempfile::TempDir,
    report: Value,
    log: PathBuf,
    ticks: Vec<TickRecord>,
}

impl Tree {
    fn of(args: &[&str]) -> Self {
        let place = folder();
        let ticks = TICKS.to_string();
        let report =
            launch("trunk", &place.path().join("run"), &[args, &["--ticks", &ticks]].concat());
        let log = PathBuf::from(text(&report, "log"));
        Self { ticks: load(&log), report, log, place }
    }

    /// A branch that ends well: its report and ticks. What comes before `AT` is
    /// the original's, answers included.
    fn branch(&self, name: &str, args: &[&str]) -> (Value, Vec<TickRecord>) {
        let at = AT.to_string();
        let out = self.place.path().join(name);
        let report = fork(&self.log, &out, &[&["--at", &at], args].concat()).expect(0).json();
        let ticks = load(Path::new(text(&report, "log")));
        assert!(ticks[..AT] == self.ticks[..AT], "another past");
        let (fork, answers) = (&report["fork"], &report["comparison"]);
        assert_eq!((&fork["at_tick"], &fork["frames_equal"]), (&AT.into(), &AT.into()));
        assert_eq!([&answers["compared"], &answers["equal"]], [&Value::from(AT); 2]);
        (report, ticks)
    }

    fn verifies(&self, report: &Value, args: &[&str]) {
        let log = text(report, "log");
        let said = sim_server(&[&["verify", log], args].concat()).expect(0).stdout;
        let exact =
            format!("bit-exact: {} ticks, digest {}", report["ticks"], text(report, "digest"));
        assert!(said.starts_with(&exact), "{said}");
    }
}

#[test]
fn noise_that_the_change_does_not_concern_is_the_originals() {
    let tree = Tree::of(&[]);
    let (report, ticks) = tree.branch("lidar", &["--set", "lidar.dropout=0.25"]);
    let (mut same, mut dropped) = (0, 0);
    for (a, b) in tree.ticks.iter().zip(&ticks) {
        assert_eq!((a.truth, a.ticks, a.command), (b.truth, b.ticks, b.command), "{}", a.tick);
        for (a, b) in a.ranges_m.iter().flatten().zip(b.ranges_m.iter().flatten()) {
            assert!(a.to_bits() == b.to_bits() || *b == 8.0, "{a} {b}");
            same += u32::from(a == b);
            dropped += u32::from(a != b);
        }
    }
    assert!(same > 2000 && dropped > 300, "{same} {dropped}");
    let fork = &report["fork"];
    assert_eq!((&fork["truths_differ_at"], &fork["final_m"]), (&Value::Null, &0.0.into()));
    // Dead reckoning does not look at ranges.
    let original = timeless(&tree.report["scores"]);
    assert_eq!(timeless(&fork["original_scores"]), original);
    assert_eq!(timeless(&report["scores"]), original);
    tree.verifies(&report, &["--clients"]);
    let info = sim_server(&["info", text(&report, "log")]).expect(0).stdout;
    assert!(info.contains("source    forked at tick 60;"), "{info}");

    // Nothing changed: the same world; and a longer one begins like it.
    let (report, _) = tree.branch("same", &["--without", "score"]);
    assert_eq!(report["world_digest"], tree.report["world_digest"]);
    assert_eq!(report["digest"], tree.report["digest"]);
    let (report, ticks) = tree.branch("longer", &["--without", "score", "--ticks", "130"]);
    assert!(ticks.len() == 130 && ticks[..TICKS] == tree.ticks[..]);
    assert_eq!(report["fork"]["ticks_compared"], TICKS - AT);
}

#[test]
fn a_driven_run_goes_on_with_its_driver_after_the_change() {
    let tree = Tree::of(&["driver", "--without", "score"]);
    let slips = ["--set", "robot.slip_std=0.2"];
    let (report, ticks) = tree.branch("slip", &slips);
    let fork = &report["fork"];
    assert_eq!(fork["truths_differ_at"], AT);
    let [a, b] = [&tree.ticks, &ticks].map(|t| t[TICKS - 1].truth.unwrap());
    let final_m = (a[0] - b[0]).hypot(a[1] - b[1]);
    assert!((fork["final_m"].as_f64().unwrap() - final_m).abs() < 1e-12 && final_m > 0.001);
    assert!(fork["greatest"][0].as_f64().unwrap() >= final_m);
    // The command is the driver's answer to the tick before, all along.
    for pair in ticks.windows(2) {
        let said = pair[0].replies[0].command().unwrap();
        assert_eq!(said.v_m_s, pair[1].command.v_m_s, "tick {}", pair[1].tick);
    }
    tree.verifies(&report, &["--clients"]);
    let (again, _) = tree.branch("again", &slips);
    assert_eq!(again["digest"], report["digest"]);
    let (other, _) = tree.branch("seed", &["--seed", "43"]);
    assert_eq!(other["fork"]["truths_differ_at"], AT);
    tree.verifies(&other, &[]);

    let bytes = fs::read(text(&other, "log")).unwrap();
    let copy = tree.place.path().join("fork.log");
    fs::write(&copy, bytes).unwrap();
    let out = tree.place.path().join("out");
    let ended = fork_refused(&copy, &out, &["--at", "70"], 2);
    assert!(ended.contains("it is a fork itself"), "{ended}");
    let ended = fork_refused(&tree.log, &out, &["--at", "70", "--without", "wander"], 2);
    assert!(ended.contains("takes away the driver"), "{ended}");
}

/// What is said on stderr; nothing is run.
#[track_caller]
fn fork_refused(log: &Path, out: &Path, args: &[&str], code: i32) -> String {
    let ended = fork(log, out, args).expect(code);
    assert!(ended.stdout.is_empty() && !out.join("run.log").exists(), "{ended:?}");
    ended.stderr
}

#[test]
fn what_cannot_be_forked_is_refused_by_name() {
    let tree = Tree::of(&["--without", "score"]);
    let out = tree.place.path().join("out");
    let at = |name: &str| tree.place.path().join(name);
    for (args, words) in [
        (&["--at", "0"][..], "--at 0: leaves nothing of the original"),
        (&["--at", "120"], "--at 120: is behind the last tick of the branch (119)"),
        (&["--at", "130", "--ticks", "200"], "has 120 complete ticks; use a tick from 1 to 120"),
        (&["--at", "9", "--set", "dt_s=0.1"], "dt_s = 0.1: was 0.02 when the run began"),
        (&["--at", "9", "--set", "lidar.beams=90"], "lidar.beams = 90: was 180"),
        (&["--at", "9", "--set", "robot.track_m=0.2"], "robot.track_m = 0.2: was 0.16"),
        (&["--at", "9", "--set", "script={kind='driver'}"], "script.kind = \"driver\": was"),
        (&["--at", "9", "--set", "robot.slip=1"], "unknown field `slip`"),
        (&["--at", "9", "--set", "robot.slip_std=-1"], "robot.slip_std = -1: is out of range"),
    ] {
        let said = fork_refused(&tree.log, &out, args, 2);
        assert!(said.contains(words), "{words:?} is not in {said}");
    }
    let ended = fork(&tree.log, tree.log.parent().unwrap(), &["--at", "9"]).expect(2);
    assert!(ended.stderr.contains("would write over it"), "{ended:?}");

    let (log, blind, key) = (path(&tree.log), at("blind"), at("key"));
    sim_server(&["seal", log, "-o", path(&blind), "--key-file", path(&key)]).expect(0);
    assert!(fork_refused(&blind, &out, &["--at", "9"], 2).contains("it is blind"));
    // A past that does not come again: the record was changed.
    let mut bytes = fs::read(&tree.log).unwrap();
    let range = tree.ticks[50].ranges_m.as_ref().unwrap()[7].to_le_bytes();
    let place = bytes.windows(8).position(|w| w == range).unwrap();
    bytes[place] ^= 1;
    fs::write(at("flipped"), &bytes).unwrap();
    let said = fork_refused(&at("flipped"), &out, &["--at", "51"], 1);
    assert!(said.contains("tick 50: the checksum of its record fails"), "{said}");
    fork(&at("flipped"), &out, &["--at", "50", "--quiet"]).expect(0);
}
