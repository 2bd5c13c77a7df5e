//! Logs as messages of ROS 2 and back: other programs' readers agree on every message,
//! and what comes back is what went out.

use std::collections::BTreeMap;

use mcap::{MessageStream, Summary};
use rusty_contract::digest::hex;
use rusty_contract::log::Ending;
use rusty_ros::from_cdr;
use rusty_ros::messages::{Clock, LaserScan, PoseStamped, PoseWithCovarianceStamped};
use rusty_tests::*;
use serde::de::DeserializeOwned;

/// What the messages of a topic say, with their times in ns.
type Messages<M> = Vec<(u64, M)>;

#[track_caller]
fn export(what: &str, log: &Path, args: &[&str], code: i32) -> Ended {
    sim_server(&[&["export", what, arg(log)], args].concat()).expect(code)
}

#[track_caller]
fn import(what: &str, input: &Path, log: &Path, args: &[&str], code: i32) -> Ended {
    let io = ["import", what, arg(input), "-o", arg(log)];
    sim_server(&[&io, args].concat()).expect(code)
}

fn topic<M: DeserializeOwned>(bytes: &[u8], name: &str) -> Messages<M> {
    let messages = MessageStream::new(bytes).unwrap().map(Result::unwrap);
    let wanted = messages.filter(|message| message.channel.topic == name);
    wanted.map(|message| (message.log_time, from_cdr(&message.data).unwrap())).collect()
}

fn as_f32(ranges_m: &[f64], max_m: f64) -> Vec<f32> {
    ranges_m.iter().map(|r| if *r < max_m { *r as f32 } else { f32::INFINITY }).collect()
}

#[test]
fn an_mcap_file_has_every_tick_of_the_log() {
    let (place, log) = logged("mcap", &["--ticks", "200"]);
    let out = place.at("run.mcap");
    export("mcap", &log, &["--truth"], 0);
    let bytes = fs::read(&out).unwrap();
    let (header, ticks) = load(&log);
    let ns = |tick: &TickRecord| (tick.time_s(header.config.dt_s) * 1e9).round() as u64;
    let clock: Messages<Clock> = topic(&bytes, "/clock");
    assert_eq!(clock.len(), 200);
    let max_m = header.config.lidar.range_max_m;
    let scans: Messages<LaserScan> = topic(&bytes, "/scan");
    let of_log: Vec<(u64, Vec<f32>)> = ticks
        .iter()
        .filter_map(|tick| Some((ns(tick), as_f32(tick.ranges_m.as_ref()?, max_m))))
        .collect();
    assert_eq!(scans.iter().map(|(t, scan)| (*t, scan.ranges.clone())).collect::<Vec<_>>(), of_log);
    assert_eq!(of_log.len(), 40);
    let truth: Messages<PoseStamped> = topic(&bytes, "/truth/pose");
    let estimates: Messages<PoseWithCovarianceStamped> = topic(&bytes, "/dead_reckoning/pose");
    assert_eq!((truth.len(), estimates.len()), (200, 200));
    for ((time_ns, pose), tick) in truth.iter().zip(&ticks) {
        let (written, real) = (SE2::from(pose.pose), tick.pose_in_world().unwrap());
        assert_eq!((*time_ns, written.x(), written.y()), (ns(tick), real.x(), real.y()));
        assert!((written.theta() - real.theta()).abs() < 1e-14);
    }
    let summary = Summary::read(&bytes).unwrap().unwrap();
    assert_eq!(summary.stats.unwrap().metadata_count, 1);
    let Ending::Complete(trailer) = Log::read(&log).ending else { panic!("the log is cut") };
    assert!(holds(&bytes, hex(&trailer.run_digest).as_bytes()));

    // One log, one file; without being asked for, no truth.
    let again = place.at("again.mcap");
    export("mcap", &log, &["--truth", "-o", arg(&again)], 0);
    assert!(fs::read(&again).unwrap() == bytes);
    export("mcap", &log, &["--truth"], 2).says("--force");
    export("mcap", &log, &["--force"], 0);
    assert!(topic::<PoseStamped>(&fs::read(&out).unwrap(), "/truth/pose").is_empty());
}

#[test]
fn a_blind_log_gives_no_truth_and_no_seed() {
    let (place, log) = logged("sealed", &["--ticks", "50", "--seed", "8123456789"]);
    let (blind, key) = (place.at("blind.log"), place.at("key"));
    seal(&log, &blind, &key).expect(0);
    export("mcap", &blind, &["--truth"], 2).says("--truth");
    assert!(!place.at("blind.mcap").exists());
    export("mcap", &blind, &[], 0);
    export("mcap", &log, &[], 0);
    let [sealed, open] = ["blind.mcap", "run.mcap"].map(|f| fs::read(place.at(f)).unwrap());
    assert!(holds(&open, b"8123456789") && !holds(&sealed, b"8123456789"));
    assert_eq!(topic::<LaserScan>(&sealed, "/scan").len(), 10);
}

#[test]
fn a_bag_is_whole_or_not_there_and_replaces_bags_only() {
    let (place, log) = logged("bag", &["--ticks", "40", "--add", "ekf=ekf"]);
    let bag = place.at("bag");
    let to = ["-o", arg(&bag)];
    export("rosbag", &log, &[&to[..], &["--estimator", "ekv"]].concat(), 2).says("ekf");
    assert!(!bag.exists());
    export("rosbag", &log, &[&to[..], &["--estimator", "ekf"]].concat(), 0);
    let page = fs::read_to_string(bag.join("metadata.yaml")).unwrap();
    assert!(page.contains("version: 5\n") && page.contains("bag_0.mcap"), "{page}");
    export("rosbag", &log, &to, 2).says("--force");
    export("rosbag", &log, &[&to[..], &["--force"]].concat(), 0);
    let other = place.at("other");
    fs::create_dir(&other).unwrap();
    fs::write(other.join("mine"), "mine").unwrap();
    export("rosbag", &log, &["-o", arg(&other), "--force"], 2);
    assert_eq!(fs::read_to_string(other.join("mine")).unwrap(), "mine");
    // Nor is a bag with something else in its folder, or what is read.
    fs::write(bag.join("notes"), "mine").unwrap();
    export("rosbag", &log, &[&to[..], &["--force"]].concat(), 2).says("no other files");
    assert_eq!(fs::read_to_string(bag.join("notes")).unwrap(), "mine");
    let recorded = bag.join("bag_0.mcap");
    let bytes = fs::read(&recorded).unwrap();
    import("rosbag", &bag, &recorded, &["--force"], 2).says("read or written");
    assert!(fs::read(&recorded).unwrap() == bytes);
    let dotted = place.at("run.bag");
    fs::remove_file(bag.join("notes")).unwrap();
    fs::rename(&bag, &dotted).unwrap();
    import("rosbag", &dotted, &place.at("dotted.log"), &[], 0);
    let left = fs::read_dir(place.path()).unwrap().flatten();
    let left = left.filter(|e| e.file_name().to_string_lossy().starts_with(".export")).count();
    assert_eq!(left, 0);
}

/// The last pose by dead reckoning, from where the recording starts.
fn reckoned(log: &Path) -> SE2 {
    let (header, ticks) = load(log);
    let drive = header.config.robot.nominal().drive;
    let (mut pose, mut last) = (header.config.start, rusty_geometry::EncoderCounts::default());
    for tick in &ticks {
        pose = pose.boxplus(&rusty_geometry::odometry_delta(last, tick.ticks, &drive));
        last = tick.ticks;
    }
    header.config.start.inverse() * pose
}

#[test]
fn what_is_exported_comes_back() {
    let (place, log) = logged("back", &["--ticks", "300"]);
    let (file, bag, back) = (place.at("run.mcap"), place.at("bag"), place.at("back.log"));
    export("mcap", &log, &["--truth"], 0);
    import("mcap", &file, &back, &["--truth", "/truth/pose"], 0);
    let ((header, ticks), (again, back_ticks)) = (load(&log), load(&back));
    assert_eq!(ticks.len(), back_ticks.len());
    assert!(again.findings().is_empty(), "{:?}", again.findings());
    let max_m = header.config.lidar.range_max_m;
    let mut scans = 0;
    for (tick, back) in ticks.iter().zip(&back_ticks) {
        let times = [tick, back].map(|t| t.time_s(header.config.dt_s));
        assert!((times[0] - times[1]).abs() < 1e-9, "{times:?}");
        let ranges = [tick, back].map(|t| t.ranges_m.as_deref().map(|r| as_f32(r, max_m)));
        assert_eq!(ranges[0], ranges[1], "tick {}", tick.tick);
        scans += usize::from(ranges[0].is_some());
        if let Some(pose) = back.pose_in_world() {
            let off = tick.pose_in_world().unwrap().boxminus(&pose);
            assert!(off.norm() < 1e-9, "tick {}: {off:?}", tick.tick);
        }
    }
    assert_eq!(scans, 60);
    assert_eq!(back_ticks.iter().filter(|t| t.pose_in_world().is_some()).count(), 60);
    // Nine metres of virtual wheels, of 4.8 µm a count.
    let off = reckoned(&log).boxminus(&reckoned(&back));
    assert!(off.norm() < 1e-3, "{off:?}");

    export("rosbag", &log, &["-o", arg(&bag)], 0);
    import("rosbag", &bag, &place.at("bag.log"), &["--odom", "/tf"], 0);
    assert_eq!(records(&place.at("bag.log")).len(), 300);
    let report = replay(&back, &place.at("replayed"), &["--add", "ekf=ekf"]).expect(0).json();
    assert_eq!(named(&report, "participants", "ekf")["answers"], 300);
}

/// The estimates of a participant in a log, by tick.
fn estimates(log: &Path, name: &str) -> Vec<Option<rusty_contract::Estimate>> {
    let (header, ticks) = load(log);
    let slot = header.answering().position(|p| p.name == name).unwrap();
    ticks.iter().map(|tick| tick.replies[slot].estimate().copied()).collect()
}

#[test]
fn poses_of_a_recording_are_scored_like_a_participant() {
    let (place, log) = logged("poses", &["--ticks", "300", "--add", "ekf=ekf"]);
    let (file, tum) = (place.at("run.mcap"), place.at("ekf.tum"));
    export("mcap", &log, &["--estimator", "ekf"], 0);
    let wanted = estimates(&log, "ekf");
    let topic = ["--topic", "/ekf/pose"];
    let frames = ["--frames", "map,base_link"];
    for (poses, with_covariance) in [(topic, 300), (frames, 0)] {
        let read =
            import("trajectory", &file, &tum, &[&poses[..], &["--json", "--force"]].concat(), 0);
        assert_eq!(read.json()["poses"], 300);
        assert_eq!(read.json()["with_covariance"], with_covariance);
        let (out, again) = (place.at(poses[0]), format!("again=trajectory {}", arg(&tum)));
        let report = replay(&log, &out, &["--add", &again]).expect(0).json();
        let found = estimates(&out.join("run.log"), "again");
        for (tick, (found, wanted)) in found.iter().zip(&wanted).enumerate() {
            let (found, wanted) = (found.unwrap(), wanted.unwrap());
            let off = found.pose_in_world.boxminus(&wanted.pose_in_world);
            assert!(off.norm() < 1e-9, "tick {tick}: {off:?}");
            if with_covariance > 0 {
                let both = found.covariance.unwrap().into_iter().zip(wanted.covariance.unwrap());
                assert!(both.into_iter().all(|(a, b)| (a - b).abs() < 1e-12), "tick {tick}");
            }
        }
        let [theirs, ours] = ["again", "ekf"].map(|name| score_of(&report, name));
        let ate = [theirs, ours].map(|score| number(score, "ate_rmse_m"));
        assert!((ate[0] - ate[1]).abs() < 1e-9, "{ate:?}");
    }

    // What fits no tick says which times there are.
    let away = format!("again=trajectory {} --t-offset 1e9", arg(&tum));
    replay(&log, &place.at("away"), &["--add", &away]).expect(3).prints("--t-offset");
    import("trajectory", &file, &place.at("x.tum"), &["--topic", "/scan"], 1).says("/scan");
    import("trajectory", &file, &place.at("x.tum"), &["--frames", "map,arm"], 1)
        .says("odom in map");
    import("trajectory", &file, &place.at("x.tum"), &[], 1).says("--topic");
    import("trajectory", &file, &tum, &topic, 2).says("--force");
    assert!(!place.at("x.tum").exists());
}

#[test]
fn a_gap_in_the_odometry_is_found_without_true_poses() {
    let (place, log) = logged("gap", &["--ticks", "500"]);
    let (file, cut) = (place.at("run.mcap"), place.at("cut.mcap"));
    export("mcap", &log, &[], 0);
    // Without the odometry of three seconds.
    let bytes = fs::read(&file).unwrap();
    let mut writer = mcap::Writer::new(fs::File::create(&cut).unwrap()).unwrap();
    for message in MessageStream::new(&bytes).unwrap().map(Result::unwrap) {
        let is_odometry = message.channel.topic == "/odom";
        if !is_odometry || !(4_000_000_000..7_000_000_000).contains(&message.log_time) {
            writer.write(&message).unwrap();
        }
    }
    writer.finish().unwrap();
    let (whole, holed) = (place.at("whole.log"), place.at("cut.log"));
    let report = import("mcap", &file, &whole, &["--json"], 0).json();
    assert_eq!(report["findings"], json!([]));
    let report = import("mcap", &cut, &holed, &["--json"], 0).json();
    let found = &report["findings"][0];
    assert_eq!((&found["kind"], &found["gaps"]), (&json!("odometry-gap"), &json!(1)), "{report}");
    assert!((number(found, "gap_s") - 3.0).abs() < 0.05, "{found}");
    let (_, ticks) = load(&log);
    let true_pose =
        |time_s: f64| ticks[(time_s * 50.0).round() as usize - 1].pose_in_world().unwrap();
    let off = true_pose(7.0).boxminus(&true_pose(3.98));
    assert!((number(found, "turn_rad") - off.z).abs() < 0.1, "{found} {off:?}");
    import("mcap", &cut, &place.at("x.log"), &["--strict"], 1).says("3.0 s");
}

#[test]
fn a_scan_and_odometry_of_one_stamp_are_one_tick_in_either_order() {
    let (place, log) = logged("order", &["--ticks", "100"]);
    let (file, turned) = (place.at("run.mcap"), place.at("turned.mcap"));
    export("mcap", &log, &[], 0);
    let bytes = fs::read(&file).unwrap();
    let mut messages: Vec<_> = MessageStream::new(&bytes).unwrap().map(Result::unwrap).collect();
    messages.sort_by_key(|m| (m.log_time, m.channel.topic != "/scan"));
    let mut writer = mcap::Writer::new(fs::File::create(&turned).unwrap()).unwrap();
    messages.iter().for_each(|message| writer.write(message).unwrap());
    writer.finish().unwrap();
    let [as_written, scans_first] = [&file, &turned].map(|file| {
        let log = place.at("came.log");
        let report = import("mcap", file, &log, &["--json", "--force"], 0).json();
        assert_eq!((&report["scans"], &report["scans_with_odometry"]), (&json!(20), &json!(20)));
        load(&log).1
    });
    assert_eq!(as_written.len(), 100);
    for (a, b) in as_written.iter().zip(&scans_first) {
        assert_eq!((a.ticks, &a.ranges_m), (b.ticks, &b.ranges_m), "tick {}", a.tick);
    }
    assert_eq!(scans_first.len(), 100);
}

#[test]
fn what_is_no_recording_is_refused_with_a_remedy() {
    let (place, log) = logged("refused", &["--ticks", "60"]);
    let (file, to) = (place.at("run.mcap"), place.at("x.log"));
    export("mcap", &log, &[], 0);
    import("mcap", &file, &to, &["--scan", "/sacn"], 1).says("/scan ");
    import("mcap", &file, &to, &["--odom", "/scan"], 1).says("/odom ");
    import("mcap", &file, &to, &["--truth", "/clock"], 1).says("rosgraph_msgs/msg/Clock");
    fs::write(place.at("a.db3"), "SQLite format 3").unwrap();
    import("rosbag", &place.at("a.db3"), &to, &[], 1).says("rosbags-convert");
    import("rosbag", place.path(), &to, &[], 1).says("metadata.yaml");
    import("mcap", &log, &to, &[], 1);
    let bytes = fs::read(&file).unwrap();
    for case in 0..40 {
        let (mut damaged, mut dice) = (bytes.clone(), Dice::of("damaged bags", case));
        let at = dice.below(bytes.len() as u64) as usize;
        if dice.below(2) == 0 {
            damaged.truncate(at);
        } else {
            damaged[at] ^= 1 << dice.below(8);
        }
        let file = place.write("damaged.mcap", &damaged);
        let ended = sim_server(&["import", "mcap", &file, "-o", arg(&to), "--force"]);
        assert!(matches!(ended.code, Some(0 | 1)), "byte {at}: {ended:#?}");
        assert_eq!(ended.code == Some(0), to.exists(), "byte {at}");
        let _ = fs::remove_file(&to);
    }
}

/// A script next to this file, in the Python that reads bags.
fn python(script: &str, args: &[&Path]) -> Option<Value> {
    let python = evo::python()?;
    let script = repository().join("tests/suite/tests/results/ros").join(script);
    let output = Command::new(python).arg(script).args(args).output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    Some(serde_json::from_slice(&output.stdout).unwrap())
}

#[test]
fn two_other_readers_agree_on_every_message() {
    let place = folder();
    let log = place.at("run/run.log");
    launch("readers", &place.at("run"), &[&sensed_scenario(place.path(), "sensed.toml", "")]);
    let bag = place.at("bag");
    let made = export("rosbag", &log, &["-o", arg(&bag), "--truth", "--json"], 0).json();
    let Some(read) = python("read.py", &[&bag]) else { return };
    let (header, ticks) = load(&log);
    let counts: BTreeMap<&str, &Value> =
        list(&made, "topics").iter().map(|t| (text(t, "name"), &t["messages"])).collect();
    assert!(counts.len() >= 12, "{counts:?}");
    for (name, count) in counts {
        assert_eq!(&read["rosbags"][name], count, "{name}");
        assert_eq!(&read["mcap"][name], count, "{name}");
    }
    assert_eq!(read["different"], 0, "messages that the readers take for different ones");
    let max_m = header.config.lidar.range_max_m;
    let scans = ticks.iter().filter_map(|t| Some(as_f32(t.ranges_m.as_ref()?, max_m)));
    let of_log: Vec<u32> = scans.flatten().map(f32::to_bits).collect();
    let theirs: Vec<u32> = serde_json::from_value(read["ranges"].clone()).unwrap();
    assert!(theirs == of_log && !of_log.is_empty());
    let frames = [("odom", "base_link"), ("map", "odom"), ("base_link", "laser")];
    for (parent, child) in frames {
        assert_eq!(read["frames"][child], parent, "{read}");
    }
}

#[test]
fn a_bag_of_another_program_comes_in_and_slam_runs_on_it() {
    let place = folder();
    let (bag, log) = (place.at("theirs"), place.at("theirs.log"));
    // A room of 8 m by 6 m, driven on a circle, with chunks packed with zstd.
    let Some(made) = python("write.py", &[&bag]) else { return };
    let report = import("rosbag", &bag, &log, &["--truth", "/truth", "--json"], 0).json();
    assert_eq!(report["scans"], made["scans"]);
    assert_eq!(report["beams"], 360);
    let (header, ticks) = load(&log);
    let lidar = &header.config.lidar;
    assert!((lidar.sensor_in_body.x() - 0.2).abs() < 1e-12, "{lidar:?}");
    let out = place.at("run");
    let report = replay(&log, &out, &["--add", "slam=slam"]).expect(0).json();
    let [slam, wheels] = ["slam", "dead-reckoning"].map(|name| score_of(&report, name));
    assert!(number(slam, "ate_rmse_m") < 0.05, "{slam}");
    assert!(number(wheels, "ate_rmse_m") > 2.0 * number(slam, "ate_rmse_m"), "{wheels}");
    assert_eq!(ticks.iter().filter(|t| t.ranges_m.is_some()).count() as u64, made["scans"]);
}
