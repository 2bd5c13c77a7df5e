//! The bridge to ROS 2, with real rclpy: controllers in lockstep and free running, poses
//! of an estimator, control services, and what it prints where it cannot go on.

use nalgebra::Matrix3;
use rusty_contract::Estimate;
use rusty_geometry::{DiffDrive, EncoderCounts, Twist, odometry_delta};
use rusty_tests::python::{python, script};
use rusty_tests::ros::Ros;
use rusty_tests::*;

/// A node, and the run that it takes part in.
struct Bridged {
    ended: Ended,
    seen: Value,
    out: Folder,
}

impl Bridged {
    fn log(&self) -> PathBuf {
        self.out.at("run/run.log")
    }
}

/// A scenario with the bridge as this role, with scans in every `scan_every`-th tick.
fn scenario(ros: &Ros, role: &str, scan_every: u64, options: &[&str]) -> String {
    let script = if role == "driver" { "driver" } else { "patrol" };
    format!(
        "ticks = 250\nscan_every = {scan_every}\nstart = {{ x_m = 11.0, y_m = 3.0, theta_rad = \
         0.0 }}\n[script]\nkind = {script:?}\n[sensors]\nimu = {{}}\nsonar = {{}}\n\
         [[participant]]\nname = \"ros2\"\nrole = {role:?}\ncommand = {:?}\n{RECORDERS}",
        ros.bridge(options)
    )
}

/// Runs a scenario together with a node that answers in this way.
#[track_caller]
fn bridged(ros: &Ros, how: &str, scenario: &str, args: &[&str], code: i32) -> Bridged {
    let out = folder();
    let scenario = out.write("ros2.toml", scenario);
    let (ended, seen) = with_node(ros, how, &out, &[&["launch", &scenario], args].concat());
    Bridged { ended: ended.expect(code), seen, out }
}

/// Runs a verb, whose run goes to a folder in `out`, together with a node.
#[track_caller]
fn with_node(ros: &Ros, how: &str, out: &Folder, args: &[&str]) -> (Ended, Value) {
    let run = fresh_run("ros2");
    let node = Process::spawn(&mut ros.node(how, &out.at("seen.json")));
    let mut server = ros.command(binary("sim-server"));
    server.args(args).args(["--json", "--run", run.as_str(), "--out"]).arg(out.at("run"));
    let ended = Process::spawn(&mut server).wait();
    node.signal(Signal::INT);
    node.wait().expect(0);
    assert_eq!(participants(&run), [], "processes of the run live on");
    nothing_left(&run);
    (ended, json_file(&out.at("seen.json")))
}

fn stamp_ns(record: &TickRecord) -> u64 {
    (record.time_s(0.02) * 1e9).round() as u64
}

/// Ranges as messages have them: 32 bits, and infinite where nothing came back.
fn single(ranges_m: &[f64], range_max_m: f64) -> Vec<Value> {
    let one = |r: &f64| if *r < range_max_m { json!(f64::from(*r as f32)) } else { Value::Null };
    ranges_m.iter().map(one).collect()
}

#[test]
fn a_controller_in_lockstep_repeats_and_nothing_is_lost() {
    let Some(ros) = Ros::open() else { return };
    let scenario = scenario(&ros, "driver", 1, &["--driver", "--lockstep"]);
    let runs = [0, 1].map(|_| bridged(&ros, "record", &scenario, &["--no-report"], 0));
    let digests = runs.each_ref().map(|run| run.ended.json()["digest"].clone());
    assert_eq!(digests[0], digests[1]);
    let bytes = runs.each_ref().map(|run| fs::read(run.log()).unwrap());
    assert!(bytes[0] == bytes[1], "the logs differ");
    let run = &runs[0];
    about("verify", &run.log(), &[]).expect(0);
    let (replayed, log) = (folder(), run.log());
    with_node(&ros, "record", &replayed, &["replay", arg(&log)]).0.expect(0);
    let (_, records) = load(&log);
    let turned = records.iter().filter(|r| r.command.omega_rad_s != 0.0).count();
    assert!(turned > 20 && records.len() == 250, "it never turned");
    let drive = DiffDrive::rusty();
    let (mut pose, mut counts) = (SE2::default(), EncoderCounts::default());
    let mut expected = json!({"clock": [], "scan": [], "odom": [], "imu": [], "sonar": []});
    let mut push = |topic: &str, row: Value| expected[topic].as_array_mut().unwrap().push(row);
    for record in &records {
        let ns = stamp_ns(record);
        let delta = odometry_delta(counts, record.ticks, &drive);
        (pose, counts) = (pose.boxplus(&delta), record.ticks);
        let (half, dt_s) = (pose.theta() / 2.0, 0.02);
        let twist = [delta[0] / dt_s, delta[2] / dt_s];
        push("clock", json!(ns));
        push("odom", json!([ns, pose.x(), pose.y(), half.sin(), half.cos(), twist[0], twist[1]]));
        let imu = record.readings.get().imu().unwrap();
        push("imu", json!([ns, imu.yaw_rate_rad_s, imu.accel_x_m_s2, imu.accel_y_m_s2]));
        let ranges_m = record.ranges_m.as_ref().unwrap();
        push("scan", json!([ns, single(ranges_m, 8.0)]));
        if let Some(sonars_m) = record.readings.get().sonar_ranges_m() {
            push("sonar", json!([ns, single(sonars_m, 10.7)[0]]));
        }
    }
    // Half of the heading's sine is that of the machine's library.
    for topic in ["clock", "scan", "imu", "sonar"] {
        assert_eq!(run.seen[topic], expected[topic], "{topic}");
    }
    let rows = |seen: &Value| seen["odom"].as_array().unwrap().concat_numbers();
    let (seen, expected) = (rows(&run.seen), rows(&expected));
    assert_eq!(seen.len(), expected.len());
    assert!(seen.iter().zip(&expected).all(|(a, b)| (a - b).abs() <= 1e-12 * b.abs().max(1.0)));
    map_is_right(&run.seen["map"]);
}

trait Numbers {
    fn concat_numbers(&self) -> Vec<f64>;
}

impl Numbers for Vec<Value> {
    fn concat_numbers(&self) -> Vec<f64> {
        self.iter().flat_map(|row| row.as_array().unwrap()).map(|n| n.as_f64().unwrap()).collect()
    }
}

/// One map, with a wall wherever the apartment has one, and room where the robot starts.
#[track_caller]
fn map_is_right(maps: &Value) {
    let [map] = &maps.as_array().unwrap()[..] else { panic!("not one map: {maps}") };
    let (x_min, y_min, cell_m) = (number(map, "0"), number(map, "1"), number(map, "2"));
    let columns = map[3].as_u64().unwrap() as usize;
    let cells: Vec<i64> = map[4].as_array().unwrap().iter().map(|c| c.as_i64().unwrap()).collect();
    let at = |x_m: f64, y_m: f64| {
        let column = ((x_m - x_min) / cell_m).floor() as usize;
        let row = ((y_m - y_min) / cell_m).floor() as usize;
        cells[row.min(cells.len() / columns - 1) * columns + column.min(columns - 1)]
    };
    assert_eq!((cell_m, at(11.0, 3.0)), (f64::from(0.05f32), 0));
    for wall in &rusty_geometry::apartment().spec().walls {
        let (x_m, y_m) = ((wall.a[0] + wall.b[0]) / 2.0, (wall.a[1] + wall.b[1]) / 2.0);
        assert_eq!(at(x_m, y_m), 100, "{wall:?}");
    }
    let walls = cells.iter().filter(|cell| **cell == 100).count();
    assert!(walls + cells.iter().filter(|cell| **cell == 0).count() == cells.len());
    assert!(walls * 4 < cells.len(), "{walls} of {} cells", cells.len());
}

#[test]
fn commands_without_a_stamp_answer_as_those_with_one() {
    let Some(ros) = Ros::open() else { return };
    let run = |how, kind| {
        let options = ["--driver", "--lockstep", "--cmd-vel-type", kind];
        let run = bridged(&ros, how, &scenario(&ros, "driver", 5, &options), &["--no-report"], 0);
        assert_eq!(run.seen["scan"].as_array().unwrap().len(), 50);
        load(&run.log()).1.iter().map(|r| r.command).collect::<Vec<_>>()
    };
    let commands = run("record", "stamped");
    assert!(commands.iter().any(|c| c.omega_rad_s != 0.0), "it never turned");
    assert_eq!(commands, run("plain", "twist"));
}

#[test]
fn a_controller_may_answer_the_clock_of_every_tick() {
    let Some(ros) = Ros::open() else { return };
    let scenario = scenario(&ros, "driver", 0, &["--driver", "--lockstep", "clock"]);
    let run = bridged(&ros, "clock", &scenario, &["--no-report"], 0);
    let records = load(&run.log()).1;
    let stamps: Vec<u64> = records.iter().map(stamp_ns).collect();
    assert_eq!((&run.seen["clock"], stamps.len()), (&json!(stamps), 250));
    for (record, k) in records.iter().zip(1..) {
        let command = record.replies[0].command().unwrap();
        assert_eq!(command, Twist { v_m_s: f64::from(k) / 1000.0, omega_rad_s: 0.0 });
    }
}

#[test]
fn a_controller_that_falls_silent_is_named_with_its_tick() {
    let Some(ros) = Ros::open() else { return };
    let options = ["--driver", "--lockstep", "--answer-timeout", "1"];
    let run = bridged(&ros, "silent", &scenario(&ros, "driver", 1, &options), &[], 1);
    let report = run.ended.json();
    let loss = &list(&report, "losses")[0];
    assert_eq!(
        (text(loss, "name"), text(loss, "kind"), &loss["tick"]),
        ("ros2", "failed", &json!(20))
    );
    let talk = fs::read_to_string(run.out.at("run/ros2.txt")).unwrap();
    assert!(talk.contains("lockstep failed: tick 20: expected an answer on cmd_vel"), "{talk}");
    assert!(!talk.contains("Traceback"), "{talk}");
}

#[test]
fn free_running_obeys_commands_without_a_stamp_until_the_dead_man_stops() {
    let Some(ros) = Ros::open() else { return };
    let scenario = scenario(&ros, "driver", 5, &["--wait-for", "15", "--rate", "4"]);
    let run = bridged(&ros, "twist", &scenario, &["--no-report"], 0);
    about("verify", &run.log(), &[]).expect(0);
    let (_, records) = load(&run.log());
    let given = Twist { v_m_s: 0.25, omega_rad_s: 0.5 };
    let obeyed = records.iter().filter(|record| record.command == given).count();
    assert!((25..240).contains(&obeyed), "{obeyed}");
    assert_eq!(records[249].command, Twist::default());
    assert!(records.iter().all(|r| r.command == given || r.command == Twist::default()));
}

#[test]
fn poses_are_the_answers_of_an_estimator_and_odometry_carries_them_on() {
    let Some(ros) = Ros::open() else { return };
    let scenario = scenario(&ros, "estimator", 5, &["--lockstep", "--pose", "pose"]);
    let run = bridged(&ros, "poses", &scenario, &[], 0);
    let (_, records) = load(&run.log());
    let sent = run.seen["poses"].as_array().unwrap();
    assert_eq!(sent.len(), 50);
    let mut pose = SE2::default();
    let mut counts = EncoderCounts::default();
    for record in &records {
        let delta = odometry_delta(counts, record.ticks, &DiffDrive::rusty());
        counts = record.ticks;
        pose = pose.boxplus(&delta);
        if record.tick % 5 == 0 {
            let row = &sent[record.tick as usize / 5];
            assert_eq!(row[0].as_u64().unwrap(), stamp_ns(record));
            pose = SE2::new(number(row, "1"), number(row, "2"), number(row, "3"));
        }
        let Reply::Estimate(Estimate { pose_in_world, covariance, .. }) = record.replies[0] else {
            panic!("{:?}", record.replies)
        };
        let error = pose_in_world.boxminus(&pose);
        assert!(error.norm() < 1e-9, "tick {}: {error}", record.tick);
        if record.tick % 5 == 0 {
            // Along the axes of the map, then of the body.
            let (s, c) = pose.theta().sin_cos();
            let turn = Matrix3::new(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0);
            let sent = Matrix3::new(0.04, 0.01, 0.0, 0.01, 0.09, 0.0, 0.0, 0.0, 0.0025);
            let expected = turn * sent * turn.transpose();
            let got = Matrix3::from_row_slice(&covariance.unwrap());
            assert!((got - expected).norm() < 1e-12, "tick {}: {got} {expected}", record.tick);
        }
    }
}

#[test]
fn a_stop_by_ctrl_c_leaves_nothing() {
    let Some(ros) = Ros::open() else { return };
    let args = ["--pace", "1", "--without", "score", "--without", "logger", "--add", "ros2"];
    let live = Live::start("serve", "ros2-stop", &[&args, &["--without", "dead-reckoning"]]);
    let words = ros.bridge(&["--run", live.run.as_str()]);
    let mut bridge = ros.command(&words[0]);
    let bridge = Process::spawn(bridge.args(&words[1..]));
    let status = || sim_server(&["control", "--json", live.run.as_str(), "status"]);
    until("ticks pass", || {
        let status = status();
        status.code == Some(0) && status.json()["ticks_done"].as_u64() > Some(20)
    });
    bridge.signal(Signal::INT);
    let ended = bridge.wait().expect(3);
    assert!(!ended.stderr.contains("Traceback"), "{ended:?}");
    let run = live.run.clone();
    live.server.wait();
    nothing_left(&run);
}

#[test]
fn without_a_controller_it_does_not_join() {
    let Some(ros) = Ros::open() else { return };
    let words = ros.bridge(&["--run", "no-such-run", "--lockstep", "--wait-for", "0.5"]);
    let ended = Process::spawn(ros.command(&words[0]).args(&words[1..])).wait().expect(1);
    ended.says("expected a publisher of cmd_vel").says("/scan within 0.5 s").says("--wait-for");
    assert!(!ended.stderr.contains("Traceback"), "{ended:?}");
}

#[test]
fn without_rclpy_it_prints_where_to_get_it() {
    let Some(python) = python() else { return };
    let mut bridge = Command::new(python);
    bridge.args(["-m", "rusty.ros2", "--run", "lab"]).env_remove("PYTHONPATH");
    let ended = Process::spawn(&mut bridge).wait().expect(1);
    ended.says("setup.bash").says("pip install \"ros-kilted-rclpy");
    assert!(ended.stderr.lines().count() == 1 && ended.stdout.is_empty(), "{ended:?}");
}

/// The package `simulation_interfaces` is not on the registry: the script has types of
/// the shape of its definitions, and calls the services directly.
#[test]
fn the_services_of_simulators_pause_step_and_stop_a_run() {
    let Some(python) = python() else { return };
    let live = Live::start("launch", "ros2-control", &[&["--ticks", "300", "--pace", "1"]]);
    until("the run can be controlled", || live.control(&["status"]));
    let args = [&script("ros2_control.py"), live.run.as_str()];
    let said = Process::spawn(Command::new(python).args(args)).wait().expect(0).stdout;
    assert_eq!(said, "served\n");
    assert_eq!(text(&live.ends_with(3).report, "ended"), "interrupted");
}
