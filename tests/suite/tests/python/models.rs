//! What Python is given in addition to the session: the plane and worlds for models,
//! logs as arrays, whole runs, examples. The Rust functions' bits, and what a
//! newcomer finds in the README.

use nalgebra::{Point2, Vector3};
use rusty_contract::log::{LogReader, Read, Source};
use rusty_contract::*;
use rusty_geometry::{DiffDrive, EncoderCounts, Scan, Twist, odometry_delta, wrap_angle};
use rusty_tests::python::{python, script};
use rusty_tests::*;

/// Runs a script among the tests to its end; gives what it printed.
#[track_caller]
pub fn says(python: &Path, file: &str, args: &[&str]) -> String {
    Process::spawn(Command::new(python).arg(script(file)).args(args)).wait().expect(0).stdout
}

/// A number between `low` and `high`.
fn between(dice: &mut Dice, low: f64, high: f64) -> f64 {
    low + (high - low) * (dice.bits() >> 11) as f64 / (1u64 << 53) as f64
}

/// The bits of all numbers in a JSON value, in order.
fn bits(value: &Value) -> Vec<u64> {
    match value {
        Value::Array(all) => all.iter().flat_map(bits).collect(),
        number => vec![number.as_f64().unwrap().to_bits()],
    }
}

#[track_caller]
fn same_bits(said: &Value, expected: impl IntoIterator<Item = f64>) {
    let expected: Vec<u64> = expected.into_iter().map(f64::to_bits).collect();
    assert!(!expected.is_empty() && bits(said) == expected, "{said}");
}

fn numbers(pose: SE2) -> [f64; 3] {
    [pose.x(), pose.y(), pose.theta()]
}

#[test]
fn the_plane_in_python_has_the_bits_of_the_plane_in_rust() {
    let Some(python) = python() else { return };
    let mut dice = Dice::of("the plane in python", 0);
    let poses: Vec<[f64; 3]> = (0..60)
        .map(|_| [(0.2, 11.8), (0.2, 8.8), (-9.0, 9.0)].map(|(a, b)| between(&mut dice, a, b)))
        .collect();
    let angles: Vec<f64> = (0..40).map(|_| between(&mut dice, -20.0, 20.0)).collect();
    let counts: Vec<[i64; 2]> =
        (0..40).map(|_| [dice.bits() as i64 >> 20, dice.bits() as i64 >> 50]).collect();
    let sensor_in_body = SE2::new(0.05, -0.02, 0.4);
    let lidar = LidarConfig { beams: 180, range_max_m: 6.0, sensor_in_body, ..Default::default() };
    let drive = DiffDrive { wheel_radius_m: 0.0331, ..DiffDrive::rusty() };
    let place = folder();
    let file = place.at("asked.json");
    let asked = json!({
        "world": "apartment", "drive": drive, "lidar": lidar, "poses": poses,
        "angles": angles, "counts": counts,
    });
    fs::write(&file, asked.to_string()).unwrap();
    let said: Value = serde_json::from_str(&says(python, "models.py", &[arg(&file)])).unwrap();

    let world = rusty_geometry::apartment();
    same_bits(&said["wrapped"], angles.iter().map(|a| wrap_angle(*a)));
    let pose = |p: &[f64; 3]| SE2::new(p[0], p[1], p[2]);
    let plane = poses.windows(2).flat_map(|pair| {
        let (p, q, tau) = (pose(&pair[0]), pose(&pair[1]), Vector3::from(pair[1]));
        let (moved, both) = (p.boxplus(&tau), p.compose(&q));
        let poses = [moved, moved, both, both, both, p.inverse(), SE2::exp(&tau)];
        let twists = [p.boxminus(&q), p.boxminus(&q), p.log()].map(<[f64; 3]>::from);
        poses.map(numbers).into_iter().chain(twists).flatten()
    });
    same_bits(&said["plane"], plane);
    let reading = |c: &[i64; 2]| EncoderCounts { left: c[0], right: c[1] };
    let deltas = counts.windows(2).flat_map(|pair| {
        <[f64; 3]>::from(odometry_delta(reading(&pair[0]), reading(&pair[1]), &drive))
    });
    same_bits(&said["odometry"], deltas);
    let origin = Point2::new(poses[0][0], poses[0][1]);
    same_bits(&said["rays"], angles.iter().map(|a| world.raycast(origin, *a, 6.0).distance_m));
    for (key, beams) in [("scans", 180), ("sixth", 30)] {
        let mut scan = Scan::new(LidarConfig { beams, ..lidar }.fan());
        let mut ranges_m = Vec::new();
        for p in &poses {
            scan.take(&world, &pose(p).compose(&sensor_in_body), 6.0);
            ranges_m.extend(scan.distances_and_walls().map(|(m, _)| m));
        }
        same_bits(&said[key], ranges_m);
    }
    let nearest = poses.iter().map(|p| world.distance_to_nearest(Point2::new(p[0], p[1])));
    same_bits(&said["distances"], nearest);
}

#[test]
fn worlds_go_through_python_unchanged_and_what_is_none_is_refused() {
    let Some(python) = python() else { return };
    let place = folder();
    let (toml, json) = (place.at("w.toml"), place.at("w.json"));
    let spec = rusty_geometry::apartment().spec().clone();
    fs::write(&toml, spec.to_toml().unwrap()).unwrap();
    fs::write(&json, spec.to_json().unwrap()).unwrap();
    says(python, "worlds.py", &[arg(&toml), arg(&json)]);
}

/// The header of a log with two who answer.
fn header(source: Source) -> LogHeader {
    let config = config_of("apartment", &["seed=18446744073709551615", "ticks=9", "scan_every=2"]);
    let mut roster = Scenario::usual_participants();
    roster.insert(1, Participant::new("second", Role::Estimator));
    LogHeader { source, ..header_of(config, roster) }
}

/// A tick with everything in it, or next to nothing.
fn record(tick: u64, has_truth: bool) -> TickRecord {
    let pose = SE2::new(tick as f64 + 0.1, -0.0, 1.0 / 3.0);
    let covariance = Some(std::array::from_fn(|i| tick as f64 + i as f64 / 7.0));
    let command = Twist { v_m_s: 0.1 * tick as f64, omega_rad_s: -1e-300 };
    let innovation = (tick > 5).then_some(Innovation { nis: tick as f64 / 3.0, degrees: 180 });
    let estimate = Reply::Estimate(Estimate { covariance, innovation, ..pose.into() });
    TickRecord {
        tick,
        stamp_s: (tick == 5).then_some(123.456),
        ticks: EncoderCounts { left: 100 + tick as i64, right: -100 },
        command,
        truth: (has_truth && tick != 3).then(|| numbers(pose)),
        ranges_m: tick.is_multiple_of(2).then(|| vec![1.5; 4 - (tick == 4) as usize]),
        replies: vec![
            pose.into(),
            match tick {
                0 => Reply::Abstain,
                1 => Reply::Missing,
                2 => Reply::Command(command),
                3 => pose.into(),
                _ => estimate,
            },
        ],
        readings: OwnedReadings::default(),
    }
}

/// The arrays that Python left must have these numbers.
fn same_columns(out: &Path, records: &[TickRecord]) {
    let same = |name: &str, expected: Vec<u8>| {
        assert!(!expected.is_empty() && fs::read(out.join(name)).unwrap() == expected, "{name}");
    };
    let floats = |numbers: &dyn Fn(&TickRecord) -> Vec<f64>| {
        records.iter().flat_map(numbers).flat_map(f64::to_le_bytes).collect::<Vec<u8>>()
    };
    let nan = f64::NAN;
    same("time_s", floats(&|r| vec![r.time_s(0.02)]));
    same("commands", floats(&|r| vec![r.command.v_m_s, r.command.omega_rad_s]));
    same("truth", floats(&|r| r.truth.unwrap_or([nan; 3]).to_vec()));
    same(
        "ranges",
        floats(&|r| {
            let scan = r.ranges_m.clone().unwrap_or_default();
            let shorter = if scan.is_empty() { 0 } else { 4 - scan.len() };
            [scan, vec![nan; shorter]].concat()
        }),
    );
    for (i, name) in ["dead-reckoning", "second"].into_iter().enumerate() {
        let pose = |r: &TickRecord| r.replies[i].estimate().map(|e| numbers(e.pose_in_world));
        same(&format!("answers-{name}"), floats(&|r| pose(r).unwrap_or([nan; 3]).to_vec()));
    }
    let covariance = |r: &TickRecord| r.replies[1].estimate().and_then(|e| e.covariance);
    same("covariances-second", floats(&|r| covariance(r).unwrap_or([nan; 9]).to_vec()));
    assert!(!out.join("covariances-dead-reckoning").exists(), "it never reported any");
    let innovation = |r: &TickRecord| r.replies[1].estimate().and_then(|e| e.innovation);
    let row = |i: Innovation| vec![i.nis, f64::from(i.degrees)];
    same("innovations-second", floats(&|r| innovation(r).map_or(vec![nan; 2], row)));
    assert!(!out.join("innovations-dead-reckoning").exists(), "it never reported any");
    let whole = |numbers: Vec<i64>| numbers.into_iter().flat_map(i64::to_le_bytes).collect();
    same("counts", whole(records.iter().flat_map(|r| [r.ticks.left, r.ticks.right]).collect()));
    let scans = records.iter().filter(|r| r.ranges_m.is_some());
    same("scan_ticks", whole(scans.map(|r| r.tick as i64).collect()));
}

#[test]
fn a_log_read_in_python_has_every_number_of_the_log() {
    let Some(python) = python() else { return };
    let place = folder();
    let (log, out) = (place.at("a.log"), place.at("arrays"));
    fs::create_dir(&out).unwrap();
    let read = |log: &Path| -> Value {
        serde_json::from_str(&says(python, "reads.py", &[arg(log), arg(&out)])).unwrap()
    };
    let records: Vec<TickRecord> = (0..9).map(|tick| record(tick, true)).collect();
    let digest = write_log(&log, &header(Source::Simulated), &records);
    let said = read(&log);
    same_columns(&out, &records);
    assert_eq!(said["shapes"]["ranges"], json!([5, 4]));
    assert_eq!(said["shapes"]["covariances-second"], json!([9, 3, 3]));
    assert_eq!(said["shapes"]["innovations-second"], json!([9, 2]));
    let info = sim_server(&["info", "--json", arg(&log)]).expect(0).json();
    for key in ["digest", "complete", "seed", "roster"] {
        assert_eq!(said[key], info[key], "{key}");
    }
    assert_eq!((text(&said, "digest"), said["seed"].as_u64()), (&*digest, Some(u64::MAX)));
    assert_eq!((&said["warnings"], &said["walls"]), (&json!([]), &json!(31)));

    // Damaged in one tick, cut off, without a truth, and no log at all.
    let mut bytes = fs::read(&log).unwrap();
    let mut reader = LogReader::open(&log).unwrap();
    let at = loop {
        let Read::Tick(entry) = reader.read().unwrap() else { panic!("no tick 6") };
        if entry.record.tick == 6 {
            break entry.at_byte as usize + 12;
        }
    };
    bytes[at] ^= 1;
    fs::write(&log, &bytes).unwrap();
    let said = read(&log);
    assert_eq!((&said["damaged"], &said["complete"]), (&json!([6]), &json!(false)));
    assert!(said["warnings"][0].as_str().unwrap().contains("LogWarning: "), "{said}");
    fs::write(&log, &bytes[..at]).unwrap();
    let said = read(&log);
    assert_eq!((&said["shapes"]["counts"], &said["complete"]), (&json!([6, 2]), &json!(false)));
    assert!(said["warnings"][0].as_str().unwrap().contains("it ends after 6 ticks"), "{said}");
    let (of, observable_digest) = ("simulation".to_owned(), "0".repeat(32));
    let blind = Source::Blind {
        of,
        observable_digest,
        ticks: 9,
        start_known: false,
        world_known: false,
        figures_known: true,
    };
    let records: Vec<TickRecord> = (0..9).map(|tick| record(tick, false)).collect();
    write_log(&log, &header(blind), &records);
    let said = read(&log);
    assert_eq!((&said["shapes"]["truth"], &said["walls"]), (&Value::Null, &Value::Null));
    assert_eq!((&said["seed"], &said["complete"]), (&Value::Null, &json!(true)));
    let readme = read(&repository().join("README.md"));
    assert_eq!(text(&readme, "error"), "RustyError");
    assert!(text(&readme, "text").contains("this is no run log"), "{readme}");
    assert_eq!(text(&read(&place.at("nowhere.log")), "error"), "FileNotFoundError");
}

#[test]
fn three_estimators_in_a_run_launched_from_python_are_scored_and_repeat_themselves() {
    let Some(python) = python() else { return };
    let (out, run, server) = (folder(), fresh_run("py"), binary("sim-server"));
    let examples = repository().join("clients/python/examples");
    let args = [arg(&server), arg(out.path()), arg(&examples), run.as_str()];
    let reports: Value = serde_json::from_str(&says(python, "launches.py", &args)).unwrap();
    let [three, hidden] = &reports.as_array().unwrap()[..] else { panic!("{reports}") };
    for report in [three, hidden] {
        nothing_left(&RunName::new(text(report, "run")).unwrap());
    }
    let score = |i: usize, key: &str| three["scores"][i][key].as_f64().unwrap();
    let names = [0, 1, 2].map(|i| text(&three["scores"][i], "name"));
    assert_eq!(names, ["dead-reckoning", "python", "particles"]);
    assert_eq!(score(0, "ate_rmse_m").to_bits(), score(1, "ate_rmse_m").to_bits());
    // The LiDAR's noise is 2 cm a beam; dead reckoning is five times as far off.
    assert!(score(2, "final_position_error_m") < 0.05 && score(2, "max_position_error_m") < 0.2);
    assert!(score(2, "mean_position_error_m") < score(0, "mean_position_error_m"));
    let found = number(hidden, "scores/0/final_position_error_m");
    assert!(found < 0.1, "a start that is hidden is found: {found} m");
    for report in [three, hidden] {
        let log = text(report, "log");
        let verdict = sim_server(&["verify", "--clients", "--json", log]).expect(0).json();
        assert_eq!(verdict["bit_exact"], true, "{verdict}");
    }
}

#[test]
fn a_launch_that_fails_says_why_and_one_that_lost_something_is_none() {
    let Some(python) = python() else { return };
    let (out, run, server) = (folder(), fresh_run("pyf"), binary("sim-server"));
    says(python, "launch_fails.py", &[arg(&server), arg(out.path()), run.as_str()]);
    assert!(out.at("run/run.log").exists());
}

/// A launch by Python that gets a signal: how Python ended, and the run.
fn launch_signalled(python: &Path, signal: Signal) -> (Ended, RunName) {
    let (out, run, server) = (folder(), fresh_run("pys"), binary("sim-server"));
    let mut command = Command::new(python);
    command.arg(script("launch_stops.py")).arg(&server).arg(out.path()).arg(run.as_str());
    let script = Process::spawn(&mut command);
    until("the run has begun", || LogReader::open(&out.at("run.log")).is_ok());
    script.signal(signal);
    (script.wait(), run)
}

#[test]
fn ctrl_c_stops_a_launch_and_leaves_nothing() {
    let Some(python) = python() else { return };
    let (ended, run) = launch_signalled(python, Signal::INT);
    assert_eq!(ended.expect(0).stdout, "interrupted\n");
    assert_eq!(participants(&run), [], "processes of the run live on");
    nothing_left(&run);
}

#[test]
fn a_launch_ends_with_the_script_that_made_it() {
    let Some(python) = python() else { return };
    for signal in [Signal::TERM, Signal::KILL] {
        let (_, run) = launch_signalled(python, signal);
        until("the run has ended", || participants(&run).is_empty());
        nothing_left(&run);
    }
}

fn readme_s_python() -> Vec<String> {
    let readme = fs::read_to_string(repository().join("README.md")).unwrap();
    let blocks = readme.split("```python\n").skip(1);
    blocks.map(|block| block.split("```").next().unwrap().to_owned()).collect()
}

#[test]
fn the_readme_s_filter_in_python_is_the_example() {
    let example = repository().join("clients/python/examples/dead_reckoning.py");
    let example = fs::read_to_string(example).unwrap();
    assert!(example.lines().count() <= 12);
    assert_eq!(readme_s_python()[0], example);
}

#[test]
fn the_readme_s_filter_in_python_takes_part_as_it_is_told_there() {
    let Some(python) = python() else { return };
    let place = folder();
    let [filter, launch] = &readme_s_python()[..] else { panic!("two pieces of Python") };
    place.write("my_filter.py", filter);
    place.write("notebook.py", launch);
    let notebook = repository().join("clients/python/examples/notebook_style.py");
    let mut places = vec![python.parent().unwrap().to_owned(), binaries().to_owned()];
    places.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap()));
    let path = std::env::join_paths(places).unwrap();
    let ends = |command: &mut Command| {
        Process::spawn(command.current_dir(place.path()).env("PATH", &path)).wait().expect(0)
    };
    let readme = fs::read_to_string(repository().join("README.md")).unwrap();
    let told = "./target/release/sim-server launch --add my-filter=\"python3 my_filter.py\"\n";
    assert!(readme.contains(told));
    let (words, run) = (["launch", "--add", "my-filter=python3 my_filter.py"], fresh_run("pyr"));
    let mut launch = Command::new(binary("sim-server"));
    launch.args(words).args(["--json", "--ticks", "300", "--run", run.as_str()]);
    let report = ends(&mut launch).json();
    nothing_left(&run);
    let score = |i: usize| report["scores"][i]["ate_rmse_m"].as_f64().unwrap();
    assert!(score(0) > 0.0 && score(0).to_bits() == score(1).to_bits());
    let said = ends(Command::new(python).arg("notebook.py")).stdout;
    assert!(said.lines().next().unwrap().parse::<f64>().unwrap() > 0.0, "{said}");
    let said = ends(Command::new(python).arg(notebook)).stdout;
    assert!(said.contains("particle-filter  ATE 0.0") && said.contains("first scan: "), "{said}");
}
