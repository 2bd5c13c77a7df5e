//! What must not change a bit (pace, load, pauses, who else takes part, how
//! they wait, in which order they come), what may change one thing only, and,
//! as a control, what must change something.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

use rustix::process::Signal;
use rusty_contract::RunName;
use rusty_contract::log::{Ending, LogReader, Read, TickRecord};
use rusty_tests::{
    Process, binary, folder, fresh_run, launch, nothing_left, send_signal, text, timeless, until,
};
use serde_json::Value;
use tempfile::TempDir;

/// The run that all others are compared with, but for what they change.
const USUAL: [&str; 3] = ["apartment", "--ticks", "300"];

/// A finished run with its log.
struct Run {
    report: Value,
    ticks: Vec<TickRecord>,
}

impl Run {
    #[track_caller]
    fn of(tag: &str, args: &[&str]) -> Self {
        let place = folder();
        let report = launch(tag, &place.path().join("out"), &[&USUAL, args].concat());
        Self::with(report)
    }

    /// Reads the log that a report names, if there is one.
    #[track_caller]
    fn with(report: Value) -> Self {
        let log = report["log"].as_str();
        let ticks = log.map(|log| read(Path::new(log))).unwrap_or_default();
        Self { report, ticks }
    }

    fn digest(&self) -> &str {
        text(&self.report, "digest")
    }

    fn world(&self) -> &str {
        text(&self.report, "world_digest")
    }

    /// Command, counts and true pose of every tick, as bits.
    fn trajectory(&self) -> Vec<[u64; 7]> {
        let row = |r: &TickRecord| {
            let ([x, y, theta], c) = (r.truth.unwrap(), r.command);
            let [v, omega, x, y, theta] = [c.v_m_s, c.omega_rad_s, x, y, theta].map(f64::to_bits);
            [r.ticks.left as u64, r.ticks.right as u64, v, omega, x, y, theta]
        };
        assert_eq!(self.ticks.len(), 300);
        self.ticks.iter().map(row).collect()
    }

    /// The poses that an estimator answered, as bits.
    fn answers(&self, name: &str) -> Vec<[u64; 3]> {
        let seats = self.report["participants"].as_array().unwrap();
        let place = seats.iter().position(|p| text(p, "name") == name).unwrap();
        let pose = |r: &TickRecord| {
            let p = r.replies[place].estimate().unwrap().pose_in_world;
            [p.x(), p.y(), p.theta()].map(f64::to_bits)
        };
        self.ticks.iter().map(pose).collect()
    }

    /// The scans as bits, with the numbers of their ticks.
    fn scans(&self) -> Vec<(u64, Vec<u64>)> {
        let bits = |ranges_m: &Vec<f64>| ranges_m.iter().map(|r| r.to_bits()).collect();
        self.ticks.iter().filter_map(|r| Some((r.tick, bits(r.ranges_m.as_ref()?)))).collect()
    }
}

fn read(log: &Path) -> Vec<TickRecord> {
    let mut reader = LogReader::open(log).unwrap();
    let mut ticks = Vec::new();
    loop {
        match reader.read().unwrap() {
            Read::Tick(entry) => ticks.push(entry.record),
            Read::End(Ending::Complete(_)) => return ticks,
            Read::End(cut) => panic!("{}: {cut:?}", log.display()),
        }
    }
}

/// The usual run as it is.
fn usual() -> &'static Run {
    static RUN: OnceLock<Run> = OnceLock::new();
    RUN.get_or_init(|| Run::of("usual", &[]))
}

/// `--add` for a second estimator that misbehaves in no or some way.
fn helper(mode: &str) -> String {
    format!("helper={} {mode}", binary("probe-client").display())
}

/// The usual run with a well-behaved second estimator.
fn with_helper() -> &'static Run {
    static RUN: OnceLock<Run> = OnceLock::new();
    RUN.get_or_init(|| Run::of("helped", &["--add", &helper("")]))
}

#[test]
fn pace_changes_no_bit() {
    assert_eq!(Run::of("pace", &["--pace", "20"]).digest(), usual().digest());
    let few = ["--ticks", "25", "--without", "score"];
    let digest = |pace: &str| {
        let place = folder();
        let report = launch("pace", place.path(), &[&few[..], &["--pace", pace]].concat());
        text(&report, "digest").to_owned()
    };
    assert_eq!(digest("real"), digest("max"));
}

#[test]
fn a_slow_client_changes_no_bit() {
    let run = Run::of("slow", &["--add", &helper("--mode slow")]);
    assert_eq!(run.digest(), with_helper().digest());
    assert_eq!(run.answers("dead-reckoning"), with_helper().answers("dead-reckoning"));
}

/// A usual run at twice real time, three seconds, that a test can stop.
struct Live {
    run: RunName,
    place: TempDir,
    server: Process,
}

impl Live {
    /// Starts it and waits until ticks have come: the logger has written some.
    fn under_way(tag: &str) -> Self {
        let (run, place) = (fresh_run(tag), folder());
        let mut shell = Command::new("sh");
        // Its talk goes to a file, where it can be read while it runs.
        shell.args(["-c", "exec \"$0\" \"$@\" 2>\"$TALK\""]).arg(binary("sim-server"));
        shell.env("TALK", place.path().join("talk.txt"));
        shell.arg("launch").args(USUAL).args(["--pace", "2", "--json", "--run", run.as_str()]);
        shell.args(["--answer-timeout", "100", "--out"]).arg(place.path().join("run"));
        let server = Process::spawn(&mut shell);
        let log = place.path().join("run/run.log");
        until("the first flush of the log", || fs::metadata(&log).is_ok_and(|m| m.len() > 0));
        Self { run, place, server }
    }

    fn talk(&self) -> String {
        fs::read_to_string(self.place.path().join("talk.txt")).unwrap()
    }

    /// The process of a participant, found by its command line.
    fn pid_of(&self, name: &str) -> u32 {
        let wanted = format!("\0--run\0{}\0--name\0{name}\0", self.run);
        let pid = |entry: fs::DirEntry| {
            let line = fs::read(entry.path().join("cmdline")).ok()?;
            let found = String::from_utf8_lossy(&line).contains(&wanted);
            found.then(|| entry.file_name().to_str()?.parse().ok()).flatten()
        };
        fs::read_dir("/proc").unwrap().flatten().find_map(pid).unwrap()
    }

    /// The run's end, which must be a good one.
    fn end(self) -> Run {
        let talk = self.talk();
        let ended = self.server.wait();
        assert_eq!(ended.code, Some(0), "{ended:#?}\n{talk}");
        nothing_left(&self.run);
        Run::with(ended.json())
    }
}

fn stop(pid: u32) {
    send_signal(pid, Signal::STOP);
    until("the process stands still", || {
        let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap();
        stat.rsplit(')').next().unwrap().trim_start().starts_with('T')
    });
}

/// How often a process has gone to sleep by itself.
fn sleeps(pid: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
    let line = status.lines().find(|l| l.starts_with("voluntary_ctxt_switches")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

#[test]
fn a_client_that_is_stopped_and_continued_changes_no_bit() {
    let live = Live::under_way("stop-dr");
    let pid = live.pid_of("dead-reckoning");
    stop(pid);
    // The server notices, says what helps, and waits.
    until("the server's remark", || live.talk().contains("dead-reckoning is slow"));
    assert!(live.talk().contains(&format!("`kill -CONT {pid}`")), "{}", live.talk());
    send_signal(pid, Signal::CONT);
    let run = live.end();
    assert_eq!(run.digest(), usual().digest());
    let seat = &run.report["participants"][0];
    assert!(seat["slow"].as_u64() > Some(0), "{seat}");
    assert_eq!(seat["answers"], 300);
}

#[test]
fn a_server_that_is_stopped_and_continued_changes_no_bit() {
    let live = Live::under_way("stop-server");
    let client = live.pid_of("dead-reckoning");
    stop(live.server.pid());
    // The clients look around many times and stay.
    let before = sleeps(client);
    until("the client's looks", || sleeps(client) > before + 20);
    live.server.signal(Signal::CONT);
    assert_eq!(live.end().digest(), usual().digest());
}

#[test]
fn whether_somebody_logs_or_scores_changes_no_bit() {
    for without in [&["logger"][..], &["score"], &["logger", "score"]] {
        let args: Vec<&str> = without.iter().flat_map(|name| ["--without", *name]).collect();
        let run = Run::of("without", &args);
        assert_eq!(run.digest(), usual().digest(), "without {without:?}");
        assert_eq!(run.report["log"].is_null(), without.contains(&"logger"));
    }
}

#[test]
fn estimators_do_not_matter_to_each_other_and_the_examples_are_dead_reckoning() {
    let first = ["--add", "first=01_first_estimator"];
    let three = Run::of("three", &[first, ["--add", "loop=02_as_a_type"]].concat());
    assert_eq!(three.report["scores"].as_array().unwrap().len(), 3);
    assert_eq!(three.world(), usual().world());
    assert_ne!(three.digest(), usual().digest(), "its roster is another");
    let alone = usual().answers("dead-reckoning");
    assert_eq!(alone.len(), 300);
    for name in ["dead-reckoning", "first", "loop"] {
        assert!(three.answers(name) == alone, "{name}");
    }
}

/// A run by `serve` whose participants are started by hand, in this order; the
/// server where its turn comes.
fn by_hand(tag: &str, order: &[(&str, &[&str])]) -> Run {
    let (run, place) = (fresh_run(tag), folder());
    let out = place.path().to_str().unwrap();
    let (mut server, mut clients) = (None, Vec::new());
    for (who, args) in order {
        let mut all = if *who == "sim-server" {
            vec!["serve", "apartment", "--ticks", "300", "--add", "helper", "--json", "--out", out]
        } else {
            vec!["--name", if *who == "probe-client" { "helper" } else { who }]
        };
        all.extend(["--run", run.as_str()]);
        all.extend(*args);
        let process = Process::start(who, &all);
        match *who {
            "sim-server" => server = Some(process),
            _ => clients.push(process),
        }
    }
    let ended = server.unwrap().wait().expect(0);
    clients.into_iter().for_each(|client| drop(client.wait().expect(0)));
    nothing_left(&run);
    Run::with(ended.json())
}

#[test]
fn the_order_in_which_they_join_changes_no_bit() {
    let (late, block) = (["--late-ms", "300"], ["--wait", "block"]);
    let plain: &[&str] = &[];
    let orders: [[(&str, &[&str]); 5]; 3] = [
        [
            ("sim-server", &block),
            ("dead-reckoning", plain),
            ("probe-client", plain),
            ("score", plain),
            ("logger", plain),
        ],
        [
            ("logger", plain),
            ("sim-server", plain),
            ("score", &block),
            ("probe-client", &late),
            ("dead-reckoning", plain),
        ],
        [
            ("probe-client", &late),
            ("score", plain),
            ("logger", &block),
            ("dead-reckoning", plain),
            ("sim-server", plain),
        ],
    ];
    for (i, order) in orders.iter().enumerate() {
        let run = by_hand("order", order);
        assert_eq!(run.digest(), with_helper().digest(), "order {i}");
        assert!(run.ticks == with_helper().ticks, "order {i}");
        let scores = [&run.report, &with_helper().report].map(|r| timeless(&r["scores"]));
        assert_eq!(scores[0], scores[1], "order {i}");
    }
}

#[test]
fn how_they_wait_changes_no_bit() {
    for how in ["balanced", "block"] {
        assert_eq!(Run::of("wait", &["--wait", how]).digest(), usual().digest(), "{how}");
    }
    // A core each: few of them, and not for long.
    let few = ["--ticks", "40", "--without", "score", "--without", "logger", "--wait"];
    let digest = |how: &str| {
        let place = folder();
        let report = launch("spin", place.path(), &[&few[..], &[how]].concat());
        text(&report, "digest").to_owned()
    };
    assert_eq!(digest("spin"), digest("balanced"));
}

#[test]
fn one_beam_more_changes_the_scans_alone() {
    let run = Run::of("beams", &["--set", "lidar.beams=181"]);
    assert!(run.trajectory() == usual().trajectory());
    assert_eq!(run.answers("dead-reckoning"), usual().answers("dead-reckoning"));
    assert!(usual().scans().iter().all(|(_, scan)| scan.len() == 180));
    assert!(run.scans().iter().all(|(_, scan)| scan.len() == 181));
    assert_ne!(run.world(), usual().world());
}

#[test]
fn dropout_takes_beams_away_and_touches_no_other() {
    let run = Run::of("dropout", &["--set", "lidar.dropout=0.2"]);
    assert!(run.trajectory() == usual().trajectory());
    let (scans, whole) = (run.scans(), usual().scans());
    assert_eq!((scans.len(), whole.len()), (60, 60));
    let mut dropped = 0;
    for ((tick, scan), (same_tick, before)) in scans.iter().zip(&whole) {
        assert_eq!((tick, scan.len()), (same_tick, before.len()));
        for (beam, (range, was)) in scan.iter().zip(before).enumerate() {
            let gone = range != was;
            assert!(!gone || *range == 8.0f64.to_bits(), "tick {tick}, beam {beam}");
            dropped += u32::from(gone);
        }
    }
    // Of 10800 beams a fifth, give or take five standard deviations of 42; a
    // beam that saw nothing anyway is not counted.
    let blind = whole.iter().flat_map(|(_, s)| s).filter(|r| **r == 8.0f64.to_bits()).count();
    let expected = 0.2 * (10_800 - blind) as f64;
    assert!((f64::from(dropped) - expected).abs() < 210.0, "{dropped} of {expected}");
}

#[test]
fn how_often_it_scans_changes_no_motion_and_no_common_scan() {
    for every in [0, 1, 7] {
        let run = Run::of("every", &["--set", &format!("scan_every={every}")]);
        assert!(run.trajectory() == usual().trajectory(), "every {every}");
        let expected = if every == 0 { 0 } else { 300u64.div_ceil(every) };
        assert_eq!(run.scans().len() as u64, expected);
        let whole = usual().scans();
        let common = |tick: u64| whole.iter().find(|(t, _)| *t == tick);
        for (tick, scan) in run.scans() {
            assert!(common(tick).is_none_or(|(_, s)| *s == scan), "every {every}, tick {tick}");
        }
    }
}

#[test]
fn what_belongs_to_the_world_does_change_it() {
    for change in [
        "seed=43",
        "robot.slip_std=0.021",
        "robot.radius_bias_right=0.001",
        "dt_s=0.021",
        "script.v_m_s=0.5",
        "start.x_m=6.001",
    ] {
        let run = Run::of("control", &["--set", change, "--without", "score"]);
        assert_ne!(run.world(), usual().world(), "{change}");
        assert!(run.trajectory() != usual().trajectory(), "{change}");
    }
    let noisier = Run::of("control", &["--set", "lidar.range_std_m=0.021"]);
    assert_ne!(noisier.world(), usual().world());
    assert!(noisier.trajectory() == usual().trajectory());
    assert!(noisier.scans() != usual().scans());
}
