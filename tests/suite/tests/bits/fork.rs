//! Forks: a run again up to a tick, to the bit, and another from there on.

use rusty_tests::*;

const TICKS: usize = 120;
const AT: usize = 60;

fn fork(log: &Path, out: &Path, args: &[&str]) -> Ended {
    run_to("fork", out, &[&["fork", arg(log)], args].concat())
}

/// A run, and branches of it.
struct Tree {
    place: Folder,
    report: Value,
    log: PathBuf,
    ticks: Vec<TickRecord>,
}

impl Tree {
    fn of(args: &[&str]) -> Self {
        let place = folder();
        let ticks = TICKS.to_string();
        let report = launch("trunk", &place.at("run"), &[args, &["--ticks", &ticks]].concat());
        let log = log_of(&report);
        Self { ticks: records(&log), report, log, place }
    }

    /// A branch that ends well: its report and ticks. What comes before `AT` is
    /// the original's, answers included.
    fn branch(&self, name: &str, args: &[&str]) -> (Value, Vec<TickRecord>) {
        let at = AT.to_string();
        let out = self.place.at(name);
        let report = fork(&self.log, &out, &[&["--at", &at], args].concat()).expect(0).json();
        let ticks = records(&log_of(&report));
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
    sim_server(&["info", text(&report, "log")]).expect(0).prints("source    forked at tick 60;");

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
    assert!((number(fork, "final_m") - final_m).abs() < 1e-12 && final_m > 0.001);
    assert!(number(fork, "greatest/0") >= final_m);
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

    let copy = tree.place.at("fork.log");
    fs::copy(log_of(&other), &copy).unwrap();
    let out = tree.place.at("out");
    fork_refused(&copy, &out, &["--at", "70"], 2, "it is a fork itself");
    let without = ["--at", "70", "--without", "wander"];
    fork_refused(&tree.log, &out, &without, 2, "takes away the driver");
}

/// Says these words, and runs nothing.
#[track_caller]
fn fork_refused(log: &Path, out: &Path, args: &[&str], code: i32, words: &str) {
    let ended = fork(log, out, args).expect(code);
    ended.says(words);
    assert!(ended.stdout.is_empty() && !out.join("run.log").exists(), "{ended:?}");
}

#[test]
fn what_cannot_be_forked_is_refused_by_name() {
    let tree = Tree::of(&["--without", "score"]);
    let out = tree.place.at("out");
    let at = |name: &str| tree.place.at(name);
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
        fork_refused(&tree.log, &out, args, 2, words);
    }
    fork(&tree.log, tree.log.parent().unwrap(), &["--at", "9"])
        .expect(2)
        .says("would write over it");

    let blind = at("blind");
    seal(&tree.log, &blind, &at("key")).expect(0);
    fork_refused(&blind, &out, &["--at", "9"], 2, "it is blind");
    // A past that does not come again: the record was changed.
    let mut bytes = fs::read(&tree.log).unwrap();
    let range = tree.ticks[50].ranges_m.as_ref().unwrap()[7].to_le_bytes();
    let place = bytes.windows(8).position(|w| w == range).unwrap();
    bytes[place] ^= 1;
    fs::write(at("flipped"), &bytes).unwrap();
    let words = "tick 50: the checksum of its record fails";
    fork_refused(&at("flipped"), &out, &["--at", "51"], 1, words);
    fork(&at("flipped"), &out, &["--at", "50", "--quiet"]).expect(0);
}
