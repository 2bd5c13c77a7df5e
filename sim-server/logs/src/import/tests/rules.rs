//! What becomes of lines, poses and stamps.

use std::f64::consts::PI;
use std::io::Write as _;

use flate2::Compression;
use flate2::write::GzEncoder;
use rusty_contract::log::Source;
use rusty_geometry::{SE2, odometry_delta};

use super::super::wheels::WHEELS;
use super::{Imported, flaser, import_bytes, import_text, odom};

const HERE: [f64; 3] = [0.0, 0.0, 0.0];

/// Δs of each tick against the one before, m.
fn steps_m(imported: &Imported) -> Vec<f64> {
    let pairs = imported.ticks.windows(2);
    pairs.map(|pair| odometry_delta(pair[0].ticks, pair[1].ticks, &WHEELS).x).collect()
}

fn assert_steps(imported: &Imported, expected_m: &[f64]) {
    let found_m = steps_m(imported);
    assert_eq!(found_m.len(), expected_m.len(), "{found_m:?}");
    for (found, expected) in found_m.iter().zip(expected_m) {
        assert!((found - expected).abs() < 1e-5, "{found_m:?} {expected_m:?}");
    }
}

/// Where dead reckoning on the counts is after tick `n`.
fn dead_reckoning(imported: &Imported, n: usize) -> SE2 {
    let mut pose = imported.header.config.start;
    for pair in imported.ticks[..=n].windows(2) {
        pose = pose.boxplus(&odometry_delta(pair[0].ticks, pair[1].ticks, &WHEELS));
    }
    pose
}

#[test]
fn a_byte_order_mark_is_no_part_of_the_first_line() {
    let text: String = [1.0, 2.0, 3.0].map(|at| odom([at, 0.0, 0.0], at)).concat();
    let marked = import_text(&format!("\u{feff}{text}")).unwrap();
    assert_eq!(steps_m(&marked), steps_m(&import_text(&text).unwrap()));
    assert!(marked.report.skipped.is_empty(), "{:?}", marked.report.skipped);
}

fn remarks(imported: &Imported) -> String {
    let Source::Recorded { format, remarks, .. } = &imported.header.source else {
        panic!("{:?}", imported.header.source);
    };
    assert_eq!(format, "carmen");
    assert_eq!(remarks, &imported.report.remarks);
    remarks.join("\n")
}

#[test]
fn a_reading_is_a_tick_and_a_scan_is_a_tick() {
    let text = "# comment\n\nPARAM robot_width 0.4 nohost 0\n".to_owned()
        + &odom(HERE, 10.5)
        + &odom([0.25, 0.0, 0.0], 10.75)
        + &flaser(180, [0.25, 0.0, 0.0], [0.25, 0.0, 0.0], 10.8)
        + "NEFF 15\nSYNC a\nNEFF 14\n"
        + &odom([0.5, 0.0, 0.0], 11.0);
    let imported = import_text(&text).unwrap();
    let report = &imported.report;
    assert_eq!((report.lines, report.readings, report.scans), (10, 3, 1));
    assert_eq!((report.anchors, report.ticks, report.beams), (0, 4, 180));
    assert_eq!(report.skipped["NEFF"], 2);
    assert_eq!(report.skipped["SYNC"], 1);
    assert_eq!(report.skipped.len(), 2);
    assert_steps(&imported, &[0.25, 0.0, 0.25]);
    let dt_s = imported.header.config.dt_s;
    let stamps_s: Vec<f64> = imported.ticks.iter().map(|t| t.time_s(dt_s)).collect();
    assert_eq!(stamps_s, [10.5, 10.75, 10.8, 11.0]);
    let scan = &imported.ticks[2];
    assert_eq!(scan.truth, Some([0.25, 0.0, 0.0]));
    assert_eq!(scan.ranges_m.as_ref().unwrap()[179], 180.0);
    for tick in [0, 1, 3] {
        assert_eq!(imported.ticks[tick].truth, None);
        assert_eq!(imported.ticks[tick].ranges_m, None);
    }
    let config = &imported.header.config;
    assert_eq!(config.scenario, "some robot");
    assert_eq!(config.world.name, "some robot");
    assert_eq!(config.world.bounds, [-9.75, -10.0, 10.25, 10.0]);
    assert_eq!(imported.header.writer, "test 1.0");
    let text = report.to_string();
    assert!(text.contains("3 readings, 0.50 m driven"), "{text}");
    assert!(remarks(&imported).contains("nothing in the log says"), "{text}");
}

/// Two scans whose echoes have the stamps given. In truth the robot moved
/// 0.1 m between readings; each correction moves it 0.3 m sideways.
fn echoed(echo_stamps: [&str; 2]) -> String {
    let echo = |y: f64, stamp: &str| format!("ODOM 0.1 {y} 0 0 0 0 {stamp} host {stamp}\n");
    odom(HERE, 50.0)
        + &odom([0.1, 0.0, 0.0], 50.2)
        + &flaser(181, [0.1, 0.3, 0.0], [0.1, 0.3, 0.0], 50.2)
        + &echo(0.3, echo_stamps[0])
        + "NEFF 15\n"
        + &odom([0.2, 0.3, 0.0], 50.4)
        + &flaser(181, [0.1, 0.6, 0.0], [0.1, 0.6, 0.0], 50.6)
        + &echo(0.6, echo_stamps[1])
        + &odom([0.2, 0.6, 0.0], 50.8)
}

#[test]
fn echoes_of_scans_are_anchors_not_readings() {
    for stamps in [
        ["0", "0"],
        ["1.08499e-42", "6.53023e-43"],
        ["-nan", "inf"],
        // Ranges that lay in memory; the second looks like a time.
        ["4.39", "51.3"],
        ["1e300", "50.6"],
    ] {
        let imported = import_text(&echoed(stamps)).unwrap();
        let report = &imported.report;
        assert_eq!((report.anchors, report.readings, report.ticks), (2, 4, 6), "{stamps:?}");
        assert_steps(&imported, &[0.1, 0.0, 0.1, 0.0, 0.1]);
        assert!(report.lateral_max_m < 1e-12, "{report:?}");
        assert!((report.distance_m - 0.3).abs() < 1e-12);
        assert!(remarks(&imported).contains("2 of 2 scans are echoed"));
        // Agrees at the first scan; the second was corrected by (-0.1, 0.3).
        let at_first = dead_reckoning(&imported, 2);
        assert!(at_first.boxminus(&SE2::new(0.1, 0.3, 0.0)).norm() < 1e-12);
        let error_m = report.end_error_m.unwrap();
        assert!((error_m - f64::hypot(0.1, 0.3)).abs() < 1e-5, "{error_m}");
    }
}

#[test]
fn a_robot_that_stands_still_makes_no_anchors() {
    // The pose of the scan, repeated, with a time that can be one.
    for stamp_s in [50.2, 50.25, 49.9, 60.0] {
        let text = odom(HERE, 50.0) + &flaser(180, HERE, HERE, 50.2) + &odom(HERE, stamp_s);
        let report = import_text(&text).unwrap().report;
        assert_eq!((report.anchors, report.readings), (0, 2), "{stamp_s}");
    }
    // At the start of a log that counts from zero, too.
    let text = odom(HERE, 0.0) + &flaser(180, HERE, HERE, 0.0) + &odom(HERE, 0.0);
    assert_eq!(import_text(&text).unwrap().report.anchors, 0);
    // Another pose is no echo, whatever its stamp; nor is one farther on.
    let there = [0.1, 0.0, 0.0];
    let text =
        odom(HERE, 50.0) + &flaser(180, HERE, HERE, 50.2) + &odom(there, 0.0) + &odom(HERE, 0.0);
    let report = import_text(&text).unwrap().report;
    assert_eq!((report.anchors, report.stamps_backwards), (0, 1));
}

#[test]
fn a_scan_with_its_own_odometry_is_a_reading() {
    let text = odom(HERE, 5.0)
        + &flaser(180, [3.0, 4.0, PI / 2.0], [0.1, 0.0, 0.0], 5.1)
        + &odom([0.3, 0.0, 0.0], 5.2)
        + &flaser(180, [3.0, 4.3, PI / 2.0], [0.4, 0.0, 0.0], 5.3);
    let imported = import_text(&text).unwrap();
    assert_eq!(imported.report.scans_with_odometry, 2);
    assert_steps(&imported, &[0.1, 0.2, 0.1]);
    assert_eq!(imported.ticks[3].truth, Some([3.0, 4.3, PI / 2.0]));
    let start = imported.header.config.start;
    assert!(start.boxminus(&SE2::new(3.0, 3.9, PI / 2.0)).norm() < 1e-5);
    assert!(imported.report.end_error_m.unwrap() < 1e-5);
    // Scans alone are enough then.
    let text = flaser(180, HERE, [1.0, 0.0, 0.0], 0.0) + &flaser(180, HERE, [1.5, 0.0, 0.0], 1.0);
    assert_steps(&import_text(&text).unwrap(), &[0.5]);
}

#[test]
fn stamps_may_go_back_and_stay_as_they_are() {
    let text = odom(HERE, 976_052_857.337_530)
        + &odom(HERE, 976_052_857.336_029)
        + &odom(HERE, 976_052_857.343_875)
        + &odom(HERE, 976_052_856.0);
    let imported = import_text(&text).unwrap();
    let report = &imported.report;
    assert_eq!((report.stamps_backwards, report.backwards_max_line), (2, 4));
    assert!((report.backwards_max_s - 1.343_875).abs() < 1e-6);
    assert_eq!(report.first_stamp_s, 976_052_857.337_530);
    assert_eq!(report.last_stamp_s, 976_052_856.0);
    let stamps_s: Vec<f64> = imported.ticks.iter().filter_map(|t| t.stamp_s).collect();
    assert_eq!(stamps_s[1], 976_052_857.336_029);
    // The mean is negative, so the length of a tick is unknown.
    assert_eq!(imported.header.config.dt_s, 0.1);
    assert!(remarks(&imported).contains("2 stamps are earlier"));
}

#[test]
fn the_first_stamp_counts_and_the_second_is_checked() {
    let text = "ODOM 0 0 0 0 0 0 976052857.5 host 0.25\n".to_owned() + &odom(HERE, 976_052_858.0);
    let imported = import_text(&text).unwrap();
    assert_eq!(imported.ticks[0].stamp_s, Some(976_052_857.5));
    assert!(remarks(&imported).contains("in 1 lines the logger's stamp differs"));
}

#[test]
fn the_number_of_beams_tells_their_bearings() {
    for (beams, last_degrees) in [
        (180, 89.0),
        (181, 90.0),
        (360, 89.5),
        (361, 90.0),
        (90, 88.0),
        (1, -90.0),
        (1080, 90.0 - 1.0 / 6.0),
    ] {
        let text = odom(HERE, 1.0) + &flaser(beams, HERE, HERE, 1.1);
        let lidar = import_text(&text).unwrap().header.config.lidar;
        assert_eq!(lidar.beams as usize, beams);
        assert_eq!(lidar.bearing_rad(0), -PI / 2.0);
        let last_rad = lidar.bearing_rad(lidar.beams - 1);
        assert!((last_rad - f64::to_radians(last_degrees)).abs() < 1e-12, "{beams}");
        assert_eq!(lidar.range_max_m, beams as f64);
    }
}

#[test]
fn ranges_stay_and_the_code_for_nothing_is_found() {
    let scan =
        |ranges: &str| odom(HERE, 1.0) + &format!("FLASER 3 {ranges} 0 0 0 0 0 0 1.5 host 1.5\n");
    for (parameter, ranges, expected_m) in [
        ("", "1 25.38 81.83", 81.83),
        ("", "73.98 81.83 81.91", 81.83),
        ("", "1 81.91 inf", 81.83),
        ("", "1 8 2", 8.0),
        ("", "0 inf 0", 81.91),
        ("PARAM robot_front_laser_max 80.99 nohost 0\n", "1 81.91 2", 80.99),
        ("PARAM robot_front_laser_max far nohost 0\n", "1 8 2", 8.0),
        ("PARAM robot_front_laser_max -1 nohost 0\n", "1 8 2", 8.0),
    ] {
        let imported = import_text(&(parameter.to_owned() + &scan(ranges))).unwrap();
        assert_eq!(imported.header.config.lidar.range_max_m, expected_m, "{ranges}");
        let kept = imported.ticks[1].ranges_m.as_ref().unwrap();
        let words: Vec<f64> = ranges.split(' ').map(|w| w.parse().unwrap()).collect();
        assert_eq!(kept, &words);
    }
}

/// A log of a laser at `offset_m` whose body drives arcs, with the poses of
/// the laser or of the body in it; every scan is echoed.
fn arcs(offset_m: f64, poses_are_laser: bool) -> String {
    let lever = SE2::new(if poses_are_laser { offset_m } else { 0.0 }, 0.0, 0.0);
    let mut text = format!("PARAM robot_frontlaser_offset {offset_m} nohost 0\n");
    let mut body = SE2::identity();
    for i in 0..200 {
        let turn_rad = 0.15 * f64::from(i % 7 - 3);
        let step_m = 0.05 + 0.01 * f64::from(i % 5);
        let half_m = 0.5 * WHEELS.track_m * turn_rad;
        body = body.boxplus(&WHEELS.tangent(step_m - half_m, step_m + half_m));
        let seen = body * lever;
        let pose = [seen.x(), seen.y(), seen.theta()];
        text += &odom(pose, f64::from(i));
        if i % 10 == 9 {
            text += &flaser(180, pose, pose, f64::from(i));
            text += &odom(pose, 0.0);
        }
    }
    text
}

#[test]
fn the_poses_are_the_lasers_if_they_move_like_it() {
    for offset_m in [-0.04, 0.2] {
        for poses_are_laser in [true, false] {
            let imported = import_text(&arcs(offset_m, poses_are_laser)).unwrap();
            let report = &imported.report;
            assert_eq!(report.anchors, 20);
            assert!(report.lateral_max_m < 1e-9, "{offset_m} {poses_are_laser}");
            let lidar = imported.header.config.lidar;
            assert_eq!(lidar.sensor_in_body, SE2::new(offset_m, 0.0, 0.0));
            // Truth is the body's: dead reckoning stays on it.
            assert!(report.end_error_m.unwrap() < 1e-3, "{report:?}");
            let of = if poses_are_laser { "laser's" } else { "robot's" };
            assert!(remarks(&imported).contains(&format!("are taken for the {of}")));
        }
    }
}

#[test]
fn by_the_format_a_scan_has_the_lasers_pose_then_the_robots() {
    let text = "PARAM robot_frontlaser_offset 0.2 nohost 0\n".to_owned()
        + &odom(HERE, 1.0)
        + &flaser(180, [0.2, 0.0, 0.0], HERE, 1.1)
        + &odom([1.0, 0.0, 0.0], 2.0)
        + &flaser(180, [1.2, 0.0, 0.0], [1.0, 0.0, 0.0], 2.1);
    let imported = import_text(&text).unwrap();
    let [x_m, y_m, _] = imported.ticks[3].truth.unwrap();
    assert!((x_m - 1.0).abs() < 1e-12 && y_m == 0.0);
    assert!(remarks(&imported).contains("those of the scans for the laser's"));
}

#[test]
fn gzip_and_carriage_returns_change_nothing() {
    let text = echoed(["0", "0"]);
    let plain = import_text(&text).unwrap();
    let crlf = import_text(&text.replace('\n', "\r\n")).unwrap();
    let unended = import_text(text.trim_end()).unwrap();
    // Two members, as `cat a.gz b.gz` makes them.
    let mut packed = Vec::new();
    let (front, back) = text.as_bytes().split_at(100);
    for half in [front, back] {
        let mut encoder = GzEncoder::new(&mut packed, Compression::default());
        encoder.write_all(half).unwrap();
        encoder.finish().unwrap();
    }
    let gzip = import_bytes("some robot.log.gz", &packed).unwrap();
    // The bytes decide, not the name.
    let unnamed = import_bytes("some robot", &packed).unwrap();
    for other in [&crlf, &unended, &gzip, &unnamed] {
        assert_eq!(other.report, plain.report);
        assert_eq!(other.ticks, plain.ticks);
        assert_eq!(other.header.config, plain.header.config);
    }
    let Source::Recorded { file, .. } = &gzip.header.source else {
        panic!("{:?}", gzip.header.source);
    };
    assert_eq!(file, "some robot.log.gz");
}

#[test]
fn a_log_without_scans_has_no_truth() {
    let imported =
        import_text(&(odom([5.0, 6.0, 0.5], 1.0) + &odom([5.5, 6.0, 0.5], 2.0))).unwrap();
    assert_eq!(imported.header.config.start, SE2::new(5.0, 6.0, 0.5));
    assert_eq!(imported.report.end_error_m, None);
    assert_eq!(imported.header.config.world.bounds, [-5.0, -4.0, 15.5, 16.0]);
    assert!(remarks(&imported).contains("no scans (FLASER)"));
    assert!(imported.report.to_string().contains("scans      none"));
    // A single reading is a run of one tick.
    assert_eq!(import_text(&odom(HERE, 1.0)).unwrap().report.ticks, 1);
}
