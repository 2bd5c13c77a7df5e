//! What must not change a bit (pace, load, pauses, who else takes part, how
//! they wait, in which order they come), and, as a control, what must change
//! something.

use std::sync::OnceLock;

use rusty_tests::*;

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
        let report = launch(tag, &place.at("out"), &[&USUAL, args].concat());
        Self::with(report)
    }

    /// Reads the log that a report names, if there is one.
    #[track_caller]
    fn with(report: Value) -> Self {
        let log = report["log"].as_str();
        let ticks = log.map(|log| Log::read(Path::new(log)));
        assert!(ticks.as_ref().is_none_or(Log::is_complete));
        let ticks = ticks.map(Log::records).unwrap_or_default();
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
        let slots = list(&self.report, "participants");
        let place = slots.iter().position(|p| text(p, "name") == name).unwrap();
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

fn digest_of(args: &[&str]) -> String {
    text(&launch("digest", folder().path(), args), "digest").to_owned()
}

#[test]
fn pace_changes_no_bit() {
    assert_eq!(Run::of("pace", &["--pace", "20"]).digest(), usual().digest());
    let few = ["--ticks", "25", "--without", "score"];
    let digest = |pace: &str| digest_of(&[&few[..], &["--pace", pace]].concat());
    assert_eq!(digest("real"), digest("max"));
}

#[test]
fn a_slow_client_changes_no_bit() {
    let run = Run::of("slow", &["--add", &helper("--mode slow")]);
    assert_eq!(run.digest(), with_helper().digest());
    assert_eq!(run.answers("dead-reckoning"), with_helper().answers("dead-reckoning"));
}

/// A usual run so slow that a test always meets it in its middle.
struct Slow {
    live: Live,
    /// Where its talk goes: it can be read while it runs.
    place: Folder,
}

impl Slow {
    fn under_way(tag: &str) -> Self {
        let (run, out, place) = (fresh_run(tag), folder(), folder());
        let args = ["--pace", "0.1", "--json", "--run", run.as_str(), "--answer-timeout", "100"];
        let args = [&["launch"], &USUAL[..], &args, &["--out", arg(out.path())]].concat();
        let mut shell = shell("exec \"$0\" \"$@\" 2>\"$TALK\"", "sim-server", &args);
        shell.env("TALK", place.at("talk.txt"));
        let live = Live { run, out, server: Process::spawn(&mut shell) };
        live.until_the_log_has_ticks();
        Self { live, place }
    }

    fn talk(&self) -> String {
        fs::read_to_string(self.place.at("talk.txt")).unwrap()
    }

    /// The rest of the run at full speed; its end must be a good one.
    fn end(self) -> Run {
        assert!(self.live.control(&["pace", "max"]), "{}", self.talk());
        let after = self.live.ends_with(0);
        Run::with(after.report)
    }
}

fn stop(pid: u32) {
    send_signal(pid, Signal::STOP);
    until("the process stands still", || is_stopped(pid));
}

/// How often a process has gone to sleep by itself.
fn sleeps(pid: u32) -> u64 {
    status(pid, "voluntary_ctxt_switches").parse().unwrap()
}

#[test]
fn a_client_that_is_stopped_and_continued_changes_no_bit() {
    let slow = Slow::under_way("stop-dr");
    let pid = slow.live.pid_of("dead-reckoning");
    stop(pid);
    // The server notices, says what helps, and waits.
    until("the server's remark", || slow.talk().contains("dead-reckoning is slow"));
    assert!(slow.talk().contains(&format!("`kill -CONT {pid}`")), "{}", slow.talk());
    send_signal(pid, Signal::CONT);
    let run = slow.end();
    assert_eq!(run.digest(), usual().digest());
    let slot = &run.report["participants"][0];
    assert!(slot["slow"].as_u64() > Some(0), "{slot}");
    assert_eq!(slot["answers"], 300);
}

#[test]
fn a_server_that_is_stopped_and_continued_changes_no_bit() {
    let slow = Slow::under_way("stop-server");
    let client = slow.live.pid_of("dead-reckoning");
    stop(slow.live.server.pid());
    // The clients look around many times and stay.
    let before = sleeps(client);
    until("the client's looks", || sleeps(client) > before + 20);
    slow.live.server.signal(Signal::CONT);
    assert_eq!(slow.end().digest(), usual().digest());
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
    assert_eq!(list(&three.report, "scores").len(), 3);
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
    let out = arg(place.path());
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
    let (server, reckons, helper) = ("sim-server", "dead-reckoning", "probe-client");
    let orders: [[(&str, &[&str]); 5]; 3] = [
        [(server, &block), (reckons, plain), (helper, plain), ("score", plain), ("logger", plain)],
        [("logger", plain), (server, plain), ("score", &block), (helper, &late), (reckons, plain)],
        [(helper, &late), ("score", plain), ("logger", &block), (reckons, plain), (server, plain)],
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
    let digest = |how: &str| digest_of(&[&few[..], &[how]].concat());
    assert_eq!(digest("spin"), digest("balanced"));
}

#[test]
fn what_belongs_to_the_world_does_change_it() {
    let changes = "seed=43 robot.slip_std=0.021 robot.radius_bias_right=0.001 dt_s=0.021 \
                   script.v_m_s=0.5 start.x_m=6.001";
    for change in changes.split_whitespace() {
        let run = Run::of("control", &["--set", change, "--without", "score"]);
        assert_ne!(run.world(), usual().world(), "{change}");
        assert!(run.trajectory() != usual().trajectory(), "{change}");
    }
    let noisier = Run::of("control", &["--set", "lidar.range_std_m=0.021"]);
    assert_ne!(noisier.world(), usual().world());
    assert!(noisier.trajectory() == usual().trajectory());
    assert!(noisier.scans() != usual().scans());
}
