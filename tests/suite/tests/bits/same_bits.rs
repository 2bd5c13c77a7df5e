//! Same configuration, seed and commands: the same bits, live, simulated
//! again, and played again. What differs by one bit is named; a log that is
//! cut or damaged never passes for a whole one.

mod damage;

use rusty_tests::*;

/// A finished run: its folder (which goes when this is dropped) and report.
struct Run {
    folder: Folder,
    report: Value,
}

impl Run {
    /// A run by `launch` that must end well.
    #[track_caller]
    fn of(tag: &str, args: &[&str]) -> Self {
        let folder = folder();
        let report = launch(tag, &folder.at("out"), args);
        Self { folder, report }
    }

    fn log(&self) -> PathBuf {
        log_of(&self.report)
    }

    fn digest(&self) -> &str {
        text(&self.report, "digest")
    }

    fn bytes(&self) -> Vec<u8> {
        fs::read(self.log()).unwrap()
    }

    /// `bytes` as a log next to the run's folder.
    fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.folder.at(name);
        fs::write(&path, bytes).unwrap();
        path
    }
}

/// A verb about logs, run to its end.
#[track_caller]
fn verb(verb: &str, logs: &[&Path], rest: &[&str]) -> Ended {
    let mut args = vec![verb];
    args.extend(logs.iter().map(|log| arg(log)));
    args.extend(rest);
    sim_server(&args)
}

/// A replay that gives every answer, the digest and the log again.
#[track_caller]
fn assert_replays(run: &Run) {
    let out = run.folder.at("again");
    let report = replay(&run.log(), &out, &[]).expect(0).json();
    let comparison = &report["comparison"];
    assert_eq!(comparison["compared"], run.report["ticks"], "{comparison}");
    assert_eq!(comparison["equal"], comparison["compared"], "{comparison}");
    assert_eq!(text(comparison, "recorded_digest"), run.digest());
    assert_eq!(text(&report, "digest"), run.digest());
    assert!(fs::read(text(&report, "log")).unwrap() == run.bytes(), "the logs differ");
    assert_eq!(timeless(&report["scores"]), timeless(&run.report["scores"]));
}

#[track_caller]
fn assert_verifies(run: &Run) {
    let said = verb("verify", &[&run.log()], &[]).expect(0).stdout;
    let ticks = &run.report["ticks"];
    assert_eq!(said.trim(), format!("bit-exact: {ticks} ticks, digest {}", run.digest()));
}

#[test]
fn the_same_seed_gives_the_same_digest_and_the_same_log() {
    let a = Run::of("same-a", &["--ticks", "300", "--seed", "7"]);
    let b = Run::of("same-b", &["--ticks", "300", "--seed", "7"]);
    assert_eq!(a.digest(), b.digest());
    assert_eq!(a.report["world_digest"], b.report["world_digest"]);
    assert!(a.bytes() == b.bytes(), "the logs differ");
    assert_eq!(timeless(&a.report["scores"]), timeless(&b.report["scores"]));
    let equal = verb("diff", &[&a.log(), &b.log()], &["--json"]).expect(0).json();
    assert_eq!((&equal["equal"], &equal["ticks_equal"]), (&true.into(), &300.into()));

    let c = Run::of("same-c", &["--ticks", "300", "--seed", "8"]);
    assert_ne!(a.digest(), c.digest());
    assert_ne!(a.report["world_digest"], c.report["world_digest"]);
    verb("diff", &[&a.log(), &c.log()], &[]).expect(4).prints("config.seed: 7 and 8");
}

#[test]
fn a_run_can_be_verified_and_played_again_to_the_bit() {
    let run = Run::of("again", &["--ticks", "300"]);
    assert_verifies(&run);
    assert_replays(&run);
}

#[test]
fn a_driven_run_repeats_verifies_and_replays() {
    let (a, b) = (
        Run::of("drive-a", &["driver", "--ticks", "400"]),
        Run::of("drive-b", &["driver", "--ticks", "400"]),
    );
    assert_eq!(a.digest(), b.digest());
    assert!(a.bytes() == b.bytes(), "the logs differ");
    // It did drive: commands came from its answers, the first of them after tick 0.
    let ticks = records(&a.log());
    assert_eq!(ticks[0].command.v_m_s, 0.0);
    for pair in ticks.windows(2) {
        assert_eq!(pair[0].replies[0].command(), Some(pair[1].command));
    }
    assert!(ticks.iter().any(|t| t.command.v_m_s > 0.0));
    assert_verifies(&a);
    assert_replays(&a);
}

#[test]
fn a_script_from_a_file_is_followed_and_lives_on_in_the_log() {
    let place = folder();
    place.write("moves.txt", "0.5 0 40\n0.2 -1.0 40 # a turn\n");
    let lines = "name = \"mine\"\n[script]\nkind = \"commands\"\nfile = \"moves.txt\"\n";
    let scenario = place.write("mine.toml", lines);
    let run = Run::of("moves", &[&scenario, "--ticks", "200"]);
    let ticks = records(&run.log());
    for (tick, entry) in ticks.iter().enumerate() {
        let expected = [[0.5, 0.0], [0.2, -1.0]].get(tick / 40).copied().unwrap_or_default();
        let command = entry.command;
        assert_eq!([command.v_m_s, command.omega_rad_s], expected, "tick {tick}");
    }
    // The log needs its scenario no longer.
    drop(place);
    assert_verifies(&run);
    assert_replays(&run);
}

/// The ways in which a run must come out on every machine and build: scenario
/// and changes, run digest, world digest.
///
/// They pin the whole chain from seed to digest: noise streams, motion, ray
/// casting, encoder counts, dead reckoning, the layout that is hashed. If one
/// of them changes without intent, a bit has changed somewhere: `sim-server
/// diff` of two logs says which. To mint them again after a change of bits that
/// is meant, run this test and copy what it prints; then write the change under
/// "Changes bits" in CHANGELOG.md.
const GOLDEN: [(&[&str], &str, &str); 3] = [
    (
        &["apartment", "--ticks", "300"],
        "9e7967ab3660105e605b05505c71adeb",
        "09b03a084edf57ef8614c01590e08711",
    ),
    (
        &["hallway", "--ticks", "200", "--set", "lidar.dropout=0.2"],
        "1cbd07416d896c1d190194561b0ca143",
        "99a9417c6df70acb7e502347befcb433",
    ),
    (
        &["figure-eight", "--ticks", "200", "--set", "robot.radius_bias_right=0.01"],
        "da6d0d4870983831cb241ed552845a21",
        "d96a20c11ec12567303e95b32e3c6bf4",
    ),
];

#[test]
fn three_runs_have_the_digests_they_always_had() {
    let mut changed = Vec::new();
    for (args, run_digest, world_digest) in GOLDEN {
        let run = Run::of("golden", &[args, &["--seed", "42", "--without", "score"]].concat());
        let world = text(&run.report, "world_digest");
        if (run.digest(), world) != (run_digest, world_digest) {
            changed.push(format!("{args:?}, {:?}, {world:?}", run.digest()));
        }
    }
    assert!(changed.is_empty(), "other bits than ever:\n{}", changed.join("\n"));
}

#[test]
fn info_has_the_documented_fields() {
    let run = Run::of("info", &["--ticks", "200", "--seed", "9"]);
    let info = verb("info", &[&run.log()], &["--json"]).expect(0).json();
    assert_eq!(info["seed"], 9);
    assert_eq!(info["config"]["seed"], 9);
    assert_eq!(info["config"]["dt_s"], 0.02);
    assert_eq!(info["config"]["scenario"], "apartment");
    assert!(!list(&info["config"]["world"], "walls").is_empty());
    let roster: Vec<&str> = list(&info, "roster").iter().map(|p| text(p, "name")).collect();
    assert_eq!(roster, ["dead-reckoning", "score", "logger"]);
    assert_eq!((&info["ticks"], &info["scans"]), (&200.into(), &40.into()));
    assert_eq!((&info["complete"], &info["damaged_records"]), (&true.into(), &0.into()));
    assert_eq!(text(&info, "digest"), run.digest());
    assert_eq!(info["world_digest"], run.report["world_digest"]);

    let ticks = records(&run.log());
    for n in [0usize, 5, 6, 199] {
        let tick = verb("info", &[&run.log()], &["--tick", &n.to_string(), "--json"]);
        let (tick, record) = (tick.expect(0).json(), &ticks[n]);
        assert_eq!(tick["tick"], n);
        assert_eq!(tick["time_s"], (n + 1) as f64 * 0.02);
        assert_eq!(tick["left_ticks"], record.ticks.left);
        assert_eq!(tick["right_ticks"], record.ticks.right);
        assert_eq!(tick["command"]["v_m_s"], record.command.v_m_s);
        assert_eq!(tick["command"]["omega_rad_s"], record.command.omega_rad_s);
        let names = ["x_m", "y_m", "theta_rad"];
        assert_eq!(names.map(|n| tick["truth"][n].as_f64().unwrap()), record.truth.unwrap());
        assert_eq!(tick["ranges"].as_array().map(Vec::len), (n % 5 == 0).then_some(180));
        let pose = record.replies[0].estimate().unwrap().pose_in_world;
        assert_eq!(tick["answers"][0]["name"], "dead-reckoning");
        let said = names.map(|n| tick["answers"][0]["pose"][n].as_f64().unwrap());
        assert_eq!(said, [pose.x(), pose.y(), pose.theta()]);
    }
    verb("info", &[&run.log()], &["--tick", "200"])
        .expect(2)
        .says("has no tick 200: it has 200 ticks");
}

#[test]
fn a_log_without_scans_stays_under_a_hundred_bytes_a_tick() {
    let run = Run::of("small", &["--ticks", "2000", "--set", "scan_every=0"]);
    let per_tick = run.bytes().len() as f64 / 2000.0;
    assert!(per_tick < 100.0, "{per_tick} bytes a tick");
}

#[test]
fn every_client_works_on_a_log() {
    let run = Run::of("clients", &["--ticks", "200"]);
    let log = run.log();
    let log_arg = arg(&log);
    let ticks = records(&log);

    let said = execute("dead-reckoning", &["--log", log_arg]).expect(0);
    said.says("200 of 200 answers equal");
    let mut lines = said.stdout.lines();
    assert_eq!(lines.next(), Some("tick,time_s,x_m,y_m,theta_rad,v_m_s,omega_rad_s"));
    let rows: Vec<&str> = lines.collect();
    assert_eq!(rows.len(), ticks.len());
    for (row, entry) in rows.iter().zip(&ticks) {
        let pose = entry.replies[0].estimate().unwrap().pose_in_world;
        let cells: Vec<f64> =
            row.trim_end_matches(',').split(',').map(|c| c.parse().unwrap()).collect();
        let (tick, time_s) = (entry.tick as f64, entry.time_s(0.02));
        assert_eq!(cells, [tick, time_s, pose.x(), pose.y(), pose.theta()], "{row}");
    }

    let out = run.folder.at("read");
    let out_arg = arg(&out);
    execute("score", &["--log", log_arg, "--out", out_arg]).expect(0);
    let scores = json_file(&out.join("score.json"));
    assert_eq!(scores["scores"], timeless(&run.report["scores"]));
    assert_eq!(text(&scores, "digest"), run.digest());
    for file in ["report.html", "report.svg", "report.png"] {
        assert!(out.join(file).exists(), "{file}");
    }

    execute("logger", &["--log", log_arg, "--out", out_arg]).expect(0);
    assert!(fs::read(out.join("run.log")).unwrap() == run.bytes(), "the logs differ");
}

#[test]
fn a_log_that_is_read_is_not_written_over() {
    let run = Run::of("over", &["--ticks", "200", "--without", "score"]);
    let (log, before) = (run.log(), run.bytes());
    let (log_arg, out) = (arg(&log), arg(log.parent().unwrap()));
    let name = fresh_run("over");
    for more in [&[][..], &["--force"], &["--force", "--without", "logger"]] {
        let args = [&["--run", name.as_str(), "--out", out][..], more].concat();
        verb("replay", &[&log], &args).expect(2).says("write over it");
    }
    execute("logger", &["--log", log_arg, "--out", out]).expect(2).says("is the log being read");
    assert!(run.bytes() == before, "the log was touched");
}
