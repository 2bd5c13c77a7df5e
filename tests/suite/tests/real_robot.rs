//! Recordings of real robots, from their CARMEN logs to scores and pictures,
//! through the same programs as any simulated run; and recordings that are
//! none, refused with the line and the field.

use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};

use flate2::read::GzDecoder;
use flate2::{Compression, write::GzEncoder};
use rusty_contract::log::{Ending, LogReader, Read, TickRecord};
use rusty_tests::{
    Ended, Process, folder, fresh_run, nothing_left, real_data, sim_server, text, timeless,
};
use serde_json::Value;

/// What a recording holds, read in the plainest way.
#[derive(Default)]
struct Plain {
    lines: u64,
    scans: u64,
    readings: u64,
    echoes: u64,
    /// Stamp of every reading and scan, in file order, s.
    stamps_s: Vec<f64>,
    /// Ranges of every scan, m.
    ranges_m: Vec<Vec<f64>>,
    /// Way along the corrected poses of the scans, m.
    corrected_m: f64,
}

/// An `ODOM` line that repeats the pose of the `FLASER` line before it, word
/// for word, is the echo of a corrected pose and no reading of the odometry.
fn plainly(path: &Path) -> Plain {
    let mut plain = Plain::default();
    let (mut scan_pose, mut last): (Option<Vec<String>>, Option<[f64; 2]>) = (None, None);
    for line in BufReader::new(GzDecoder::new(File::open(path).unwrap())).lines() {
        let line = line.unwrap();
        plain.lines += 1;
        let words: Vec<&str> = line.split_whitespace().collect();
        let numbers =
            |words: &[&str]| -> Vec<f64> { words.iter().map(|w| w.parse().unwrap()).collect() };
        match words.first() {
            Some(&"FLASER") => {
                let beams: usize = words[1].parse().unwrap();
                let pose = &words[2 + beams..5 + beams];
                let at = numbers(pose);
                plain.scans += 1;
                plain.ranges_m.push(numbers(&words[2..2 + beams]));
                plain.stamps_s.push(words[words.len() - 3].parse().unwrap());
                let [x, y] = last.replace([at[0], at[1]]).unwrap_or([at[0], at[1]]);
                plain.corrected_m += (at[0] - x).hypot(at[1] - y);
                scan_pose = Some(pose.iter().map(|w| (*w).to_owned()).collect());
            }
            Some(&"ODOM") if scan_pose.take().is_some_and(|p| p == words[1..4]) => {
                plain.echoes += 1;
            }
            Some(&"ODOM") => {
                plain.readings += 1;
                plain.stamps_s.push(words[7].parse().unwrap());
            }
            _ => {}
        }
    }
    plain
}

/// All ticks of a log that must be complete, and its time step.
fn read(log: &Path) -> (Vec<TickRecord>, f64) {
    let mut reader = LogReader::open(log).unwrap();
    let dt_s = reader.header().config.dt_s;
    let mut ticks = Vec::new();
    loop {
        match reader.read().unwrap() {
            Read::Tick(entry) => ticks.push(entry.record),
            Read::End(Ending::Complete(_)) => return (ticks, dt_s),
            Read::End(cut) => panic!("{}: {cut:?}", log.display()),
        }
    }
}

fn import(input: &Path, output: &Path) -> Ended {
    let (input, output) = (input.to_str().unwrap(), output.to_str().unwrap());
    sim_server(&["import", "carmen", input, "-o", output, "--json"])
}

/// Plays a log to the binaries that its roster names; the report.
#[track_caller]
fn replay(log: &Path, out: &Path) -> Value {
    let run = fresh_run("real");
    let (log, out) = (log.to_str().unwrap(), out.to_str().unwrap());
    let ended = sim_server(&["replay", log, "--json", "--run", run.as_str(), "--out", out]);
    nothing_left(&run);
    ended.expect(0).json()
}

#[track_caller]
fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} is no number in {value}"))
}

/// Counts, stamps and ranges of the recording are those of the log.
fn assert_kept(report: &Value, log: &Path, plain: &Plain) {
    for (field, expected) in [
        ("lines", plain.lines),
        ("readings", plain.readings),
        ("scans", plain.scans),
        ("anchors", plain.echoes),
        ("ticks", plain.readings + plain.scans),
        ("beams", plain.ranges_m[0].len() as u64),
    ] {
        assert_eq!(report[field], expected, "{field}");
    }
    let (ticks, dt_s) = read(log);
    assert_eq!(ticks.len(), plain.stamps_s.len());
    let mut scans = plain.ranges_m.iter();
    for (tick, stamp_s) in ticks.iter().zip(&plain.stamps_s) {
        assert_eq!(tick.time_s(dt_s).to_bits(), stamp_s.to_bits(), "tick {}", tick.tick);
        assert_eq!(tick.ranges_m.is_some(), tick.truth.is_some(), "tick {}", tick.tick);
        if let Some(ranges_m) = &tick.ranges_m {
            assert_eq!(Some(ranges_m), scans.next(), "tick {}", tick.tick);
        }
    }
    assert_eq!(scans.next(), None);
}

/// The log is known for what it is: complete, and by no simulator.
fn assert_told_of(log: &Path, file: &str, plain: &Plain) {
    let path = log.to_str().unwrap();
    let info = sim_server(&["info", path, "--json"]).expect(0).json();
    assert_eq!((&info["seed"], &info["complete"]), (&Value::Null, &true.into()));
    let source = &info["source"];
    assert_eq!([text(source, "kind"), text(source, "format")], ["recorded", "carmen"]);
    assert_eq!(text(source, "file"), file);
    assert!(!source["remarks"].as_array().unwrap().is_empty());
    assert_eq!(
        (&info["scans"], &info["ticks_with_truth"]),
        (&plain.scans.into(), &plain.scans.into())
    );
    let said = sim_server(&["info", path]).expect(0).stdout;
    assert!(said.contains("none: recorded by a robot"), "{said}");
    let verdict = sim_server(&["verify", path]).expect(0);
    assert!(verdict.stderr.contains("cannot be simulated again"), "{verdict:?}");
    assert!(verdict.stdout.starts_with("intact: "), "{verdict:?}");
}

/// From the gzip file to scores and pictures.
fn check_recording(file: &str) {
    let Some(input) = real_data(file) else { return };
    let place = folder();
    let plain = plainly(&input);
    assert!(plain.scans > 100 && plain.readings > 1000 && plain.echoes > 0);
    let log = place.path().join("real.log");
    let report = import(&input, &log).expect(0).json();
    assert_kept(&report, &log, &plain);
    assert_told_of(&log, file, &plain);

    let first = replay(&log, &place.path().join("first"));
    assert_eq!(first["ticks"], plain.readings + plain.scans);
    let score = &first["scores"][0];
    assert_eq!(text(score, "name"), "dead-reckoning");
    assert_eq!(score["scored_ticks"], plain.scans);
    // Odometry drifts away from the corrected path, by metres in a building.
    let (final_m, mean_m) =
        (number(score, "final_position_error_m"), number(score, "mean_position_error_m"));
    assert!(final_m > 1.0 && final_m < 200.0, "{score}");
    assert!(mean_m > 0.1 && mean_m < final_m, "{score}");
    assert!((final_m - number(&report, "end_error_m")).abs() < 1e-6, "{score}");
    let driven_m = number(score, "distance_m");
    assert!((driven_m / plain.corrected_m - 1.0).abs() < 0.02, "{driven_m}, {}", plain.corrected_m);
    let pictures: Vec<PathBuf> =
        first["pictures"].as_array().unwrap().iter().map(|p| p.as_str().unwrap().into()).collect();
    assert_eq!(pictures.len(), 2);
    assert!(fs::read_to_string(&pictures[0]).unwrap().contains("<svg"));
    assert!(fs::read(&pictures[1]).unwrap().starts_with(b"\x89PNG"));

    // Again, from the recording and from the log that the first replay wrote.
    let second = replay(&log, &place.path().join("second"));
    assert_eq!(second["digest"], first["digest"]);
    assert_eq!(timeless(&second["scores"]), timeless(&first["scores"]));
    let logged = PathBuf::from(text(&first, "log"));
    let third = replay(&logged, &place.path().join("third"));
    assert_eq!(third["digest"], first["digest"]);
    let comparison = &third["comparison"];
    assert_eq!([&comparison["compared"], &comparison["equal"]], [&first["ticks"]; 2]);
    assert!(fs::read(text(&third, "log")).unwrap() == fs::read(&logged).unwrap());
    // And without any server.
    let alone = Process::start("dead-reckoning", &["--log", logged.to_str().unwrap()]);
    let alone = alone.wait().expect(0);
    let ticks = &first["ticks"];
    assert!(
        alone.stderr.contains(&format!("{ticks} of {ticks} answers equal")),
        "{}",
        alone.stderr
    );
}

#[test]
fn the_intel_lab_is_imported_played_and_scored() {
    check_recording("intel-corrected.log.gz");
}

#[test]
fn freiburg_101_is_imported_played_and_scored() {
    check_recording("freiburg-101-corrected.log.gz");
}

fn odom(x_m: f64, stamp_s: f64) -> String {
    format!("ODOM {x_m} 0 0 0.5 0 0 {stamp_s} robot {stamp_s}\n")
}

fn flaser(beams: usize, x_m: f64, odom_x_m: f64, stamp_s: f64) -> String {
    let mut line = format!("FLASER {beams}");
    (0..beams).for_each(|beam| write!(line, " {}", 1.0 + beam as f64 / 64.0).unwrap());
    line + &format!(" {x_m} 0 0 {odom_x_m} 0 0 {stamp_s} robot {stamp_s}\n")
}

/// A metre straight ahead by the wheels, 1.02 m by the corrected poses.
fn a_metre() -> String {
    let mut log = "# by hand\nPARAM robot_front_laser_max 8.0\n".to_owned();
    for k in 0..=10 {
        let (x_m, stamp_s) = (0.1 * f64::from(k), 100.0 + 0.1 * f64::from(k));
        log += &odom(x_m, stamp_s);
        log += &flaser(181, 1.02 * x_m, x_m, stamp_s + 0.05);
    }
    log
}

#[test]
fn a_recording_by_hand_becomes_a_run_like_any_other() {
    let place = folder();
    let (input, log) = (place.path().join("metre.log"), place.path().join("out.log"));
    fs::write(&input, a_metre()).unwrap();
    let report = import(&input, &log).expect(0).json();
    let counts = ["readings", "scans", "anchors", "ticks", "beams"].map(|f| report[f].as_u64());
    assert_eq!(counts, [11, 11, 0, 22, 181].map(Some));
    let (ticks, dt_s) = read(&log);
    assert_eq!(ticks[3].time_s(dt_s), 100.0 + 0.1 + 0.05);
    assert_eq!(ticks[3].ranges_m.as_ref().unwrap()[180], 1.0 + 180.0 / 64.0);
    assert_eq!(ticks[21].truth, Some([1.02, 0.0, 0.0]));

    let report = replay(&log, &place.path().join("run"));
    let score = &report["scores"][0];
    assert!((number(score, "final_position_error_m") - 0.02).abs() < 1e-4, "{score}");
    assert!((number(score, "distance_m") - 1.02).abs() < 1e-9, "{score}");
    let (ticks, _) = read(Path::new(text(&report, "log")));
    let pose = ticks[21].replies[0].estimate().unwrap().pose_in_world;
    assert!((pose.x() - 1.0).abs() < 1e-4 && pose.y().abs() < 1e-4, "{pose:?}");

    // Compressed, it is the same recording.
    let packed = place.path().join("metre.log.gz");
    let mut gzip = GzEncoder::new(File::create(&packed).unwrap(), Compression::default());
    gzip.write_all(a_metre().as_bytes()).unwrap();
    gzip.finish().unwrap();
    let again = place.path().join("again.log");
    import(&packed, &again).expect(0);
    assert_eq!(read(&again), read(&log));
    // Cut off, it is none.
    let whole = fs::read(&packed).unwrap();
    fs::write(&packed, &whole[..whole.len() / 2]).unwrap();
    let none = place.path().join("none.log");
    let said = import(&packed, &none).expect(1).stderr;
    assert!(said.contains("is cut off after line"), "{said}");
    assert!(!none.exists());
}

#[test]
fn a_malformed_line_is_refused_with_its_number_and_field() {
    let scan = |old: &str, new: &str| flaser(181, 2.0, 2.0, 102.0).replacen(old, new, 1);
    for (line, expected) in [
        ("ODOM 0 0 zero 0 0 0 102 robot 102\n".to_owned(), "ODOM field 3 (theta) = \"zero\""),
        ("ODOM nan 0 0 0 0 0 102 robot 102\n".to_owned(), "ODOM field 1 (x) = \"NaN\""),
        ("ODOM 2 1e300 0 0 0 0 102 robot 102\n".to_owned(), "ODOM field 2 (y) ="),
        ("ODOM 2 0 0 0 0 0 soon robot 102\n".to_owned(), "ODOM field 7 (stamp) = \"soon\""),
        ("ODOM 2 0 0\n".to_owned(), "ODOM has 3 fields"),
        (scan(" 181", " many"), "FLASER field 1 (number of beams) = \"many\""),
        (scan(" 181", " 0"), "FLASER field 1 (number of beams) = \"0\""),
        (scan(" 181", " 99999"), "at most 1080 beams"),
        (scan(" 181", " 180"), "FLASER has 191 fields after its name, 190 are needed"),
        (scan(" 1.015625", " far"), "FLASER field 3 (range of beam 1) = \"far\""),
        (scan(" 1.015625", " -1"), "FLASER field 3 (range of beam 1) = \"-1\""),
        (scan(" 1.015625", " NaN"), "FLASER field 3 (range of beam 1) = \"NaN\""),
        (flaser(90, 2.0, 2.0, 102.0), "FLASER has 90 beams, the first scan (line 4) has 181"),
    ] {
        let (sources, results) = (folder(), folder());
        let input = sources.path().join("bad.log");
        fs::write(&input, a_metre() + &line + &odom(2.1, 102.1)).unwrap();
        let output = results.path().join("out.log");
        let ended = import(&input, &output);
        assert!(matches!(ended.code, Some(1 | 2)), "{ended:#?}");
        let said = &ended.stderr;
        assert!(said.contains("bad.log: line 25: "), "{said}");
        assert!(said.contains(expected), "{expected} is not in {said}");
        assert_eq!(fs::read_dir(results.path()).unwrap().count(), 0, "{line}");
        // What was there before stays as it was.
        fs::write(&output, "mine").unwrap();
        import(&input, &output);
        assert_eq!(fs::read_to_string(&output).unwrap(), "mine");
    }
}

#[test]
fn what_is_no_recording_is_refused() {
    let place = folder();
    let output = place.path().join("out.log");
    let refused = |input: &Path, expected: &str| {
        let ended = import(input, &output);
        assert!(matches!(ended.code, Some(1 | 2)), "{ended:#?}");
        assert!(ended.stderr.contains(expected), "{}", ended.stderr);
        assert!(!output.exists());
    };
    refused(&place.path().join("nowhere.log"), "give the path of a CARMEN log");
    refused(place.path(), "no regular file");
    let input = place.path().join("in.log");
    for (content, expected) in [
        (String::new(), "no odometry in 0 lines"),
        ("hello\nworld\n".to_owned(), "what stands there is hello, world"),
        (flaser(3, 0.0, 0.0, 1.0), "1 scans alone do not tell"),
    ] {
        fs::write(&input, content).unwrap();
        refused(&input, expected);
    }
    fs::write(&input, a_metre()).unwrap();
    let same = import(&input, &input);
    assert!(matches!(same.code, Some(1 | 2)), "{same:#?}");
    assert_eq!(fs::read_to_string(&input).unwrap(), a_metre());
}
