//! Recordings of real robots, from their CARMEN logs to scores and pictures,
//! through the same programs as any simulated run; and recordings that are
//! none, refused with the line and the field.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufRead as _, BufReader, Write as _};

use flate2::read::GzDecoder;
use flate2::{Compression, write::GzEncoder};
use rusty_tests::*;

/// What a recording holds, read in the plainest way.
#[derive(Default)]
struct Plain {
    lines: u64,
    scans: u64,
    readings: u64,
    echoes: u64,
    /// Stamp of every reading and scan, in file order, s.
    stamps_s: Vec<f64>,
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
    let (header, ticks) = load(log);
    let dt_s = header.config.dt_s;
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
    assert!(Log::read(log).is_complete());
    let info = about("info", log, &["--json"]).expect(0).json();
    assert_eq!((&info["seed"], &info["complete"]), (&Value::Null, &true.into()));
    let source = &info["source"];
    assert_eq!([text(source, "kind"), text(source, "format")], ["recorded", "carmen"]);
    assert_eq!(text(source, "file"), file);
    assert!(!list(source, "remarks").is_empty());
    assert_eq!(
        (&info["scans"], &info["ticks_with_truth"]),
        (&plain.scans.into(), &plain.scans.into())
    );
    about("info", log, &[]).expect(0).prints("none: recorded by a robot");
    let verdict = about("verify", log, &[]).expect(0);
    verdict.says("cannot be simulated again");
    assert!(verdict.stdout.starts_with("intact: "), "{verdict:?}");
}

/// From the gzip file to scores and pictures.
fn check_recording(file: &str) {
    let Some(input) = real_data(file) else { return };
    let place = folder();
    let plain = plainly(&input);
    assert!(plain.scans > 100 && plain.readings > 1000 && plain.echoes > 0);
    let log = place.at("real.log");
    let report = import(&input, &log, &["--json"]).expect(0).json();
    assert_kept(&report, &log, &plain);
    assert_told_of(&log, file, &plain);

    let first = replay(&log, &place.at("first"), &[]).expect(0).json();
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
        list(&first, "pictures").iter().map(|p| p.as_str().unwrap().into()).collect();
    assert_eq!(pictures.len(), 2);
    assert!(fs::read_to_string(&pictures[0]).unwrap().contains("<svg"));
    assert!(fs::read(&pictures[1]).unwrap().starts_with(b"\x89PNG"));

    // Again, from the recording and from the log that the first replay wrote.
    let second = replay(&log, &place.at("second"), &[]).expect(0).json();
    assert_eq!(second["digest"], first["digest"]);
    assert_eq!(timeless(&second["scores"]), timeless(&first["scores"]));
    let logged = log_of(&first);
    let third = replay(&logged, &place.at("third"), &[]).expect(0).json();
    assert_eq!(third["digest"], first["digest"]);
    let comparison = &third["comparison"];
    assert_eq!([&comparison["compared"], &comparison["equal"]], [&first["ticks"]; 2]);
    assert!(fs::read(text(&third, "log")).unwrap() == fs::read(&logged).unwrap());
    // And without any server.
    let alone = execute("dead-reckoning", &["--log", arg(&logged)]).expect(0);
    let ticks = &first["ticks"];
    alone.says(&format!("{ticks} of {ticks} answers equal"));
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
    let (input, log) = (place.at("metre.log"), place.at("out.log"));
    fs::write(&input, a_metre()).unwrap();
    let report = import(&input, &log, &["--json"]).expect(0).json();
    let counts = ["readings", "scans", "anchors", "ticks", "beams"].map(|f| report[f].as_u64());
    assert_eq!(counts, [11, 11, 0, 22, 181].map(Some));
    let (header, ticks) = load(&log);
    assert_eq!(ticks[3].time_s(header.config.dt_s), 100.0 + 0.1 + 0.05);
    assert_eq!(ticks[3].ranges_m.as_ref().unwrap()[180], 1.0 + 180.0 / 64.0);
    assert_eq!(ticks[21].truth, Some([1.02, 0.0, 0.0]));

    let report = replay(&log, &place.at("run"), &[]).expect(0).json();
    let score = &report["scores"][0];
    assert!((number(score, "final_position_error_m") - 0.02).abs() < 1e-4, "{score}");
    assert!((number(score, "distance_m") - 1.02).abs() < 1e-9, "{score}");
    let ticks = records(&log_of(&report));
    let pose = ticks[21].replies[0].estimate().unwrap().pose_in_world;
    assert!((pose.x() - 1.0).abs() < 1e-4 && pose.y().abs() < 1e-4, "{pose:?}");

    // Compressed, it is the same recording.
    let packed = place.at("metre.log.gz");
    let mut gzip = GzEncoder::new(File::create(&packed).unwrap(), Compression::default());
    gzip.write_all(a_metre().as_bytes()).unwrap();
    gzip.finish().unwrap();
    let again = place.at("again.log");
    import(&packed, &again, &["--json"]).expect(0);
    assert_eq!(records(&again), records(&log));
    // Cut off, it is none.
    let whole = fs::read(&packed).unwrap();
    fs::write(&packed, &whole[..whole.len() / 2]).unwrap();
    let none = place.at("none.log");
    import(&packed, &none, &["--json"]).expect(1).says("is cut off after line");
    assert!(!none.exists());
}

#[test]
fn what_is_no_recording_is_refused() {
    let place = folder();
    let output = place.at("out.log");
    let refused = |input: &Path, expected: &str| {
        let ended = import(input, &output, &["--json"]);
        assert!(matches!(ended.code, Some(1 | 2)), "{ended:#?}");
        ended.says(expected);
        assert!(!output.exists());
    };
    refused(&place.at("nowhere.log"), "give the path of a CARMEN log");
    refused(place.path(), "no regular file");
    let input = place.at("in.log");
    for (content, expected) in [
        (String::new(), "no odometry in 0 lines"),
        ("hello\nworld\n".to_owned(), "what stands there is hello, world"),
        (flaser(3, 0.0, 0.0, 1.0), "1 scans alone do not tell"),
    ] {
        fs::write(&input, content).unwrap();
        refused(&input, expected);
    }
    fs::write(&input, a_metre()).unwrap();
    let same = import(&input, &input, &["--json"]);
    assert!(matches!(same.code, Some(1 | 2)), "{same:#?}");
    assert_eq!(fs::read_to_string(&input).unwrap(), a_metre());
}
