//! Echoes of corrected poses are recognised in the whole file.

use rusty_geometry::{SE2, odometry_delta};

use super::super::wheels::WHEELS;
use super::{Imported, flaser, import_text, odom};

const SCANS: usize = 20;
/// Readings before each scan, 0.1 m apart.
const READINGS: usize = 4;

fn triple(pose: SE2) -> [f64; 3] {
    [pose.x(), pose.y(), pose.theta()]
}

/// Readings along an arc, scans whose poses are corrected by up to 20 cm, and
/// behind each scan its echo. `stamp_s` is the stamp of a line, `echo_s` that of
/// the echo of a scan.
fn corrected(stamp_s: impl Fn(usize) -> f64, echo_s: impl Fn(usize, f64) -> f64) -> String {
    let (mut pose, mut line) = (SE2::identity(), 0);
    let mut text = odom(triple(pose), stamp_s(line));
    for scan in 0..SCANS {
        for _ in 0..READINGS {
            line += 1;
            pose = pose.boxplus(&WHEELS.tangent(0.099, 0.101));
            text += &odom(triple(pose), stamp_s(line));
        }
        line += 1;
        pose = pose * SE2::new(0.02, 0.05 * (scan % 5) as f64 - 0.1, 0.01);
        text += &flaser(30, triple(pose), triple(pose), stamp_s(line));
        text += &odom(triple(pose), echo_s(scan, stamp_s(line)));
    }
    text
}

fn assert_echoes(imported: &Imported) {
    let report = &imported.report;
    assert_eq!((report.anchors, report.scans), (SCANS as u64, SCANS as u64));
    assert_eq!(report.readings, (1 + SCANS * READINGS) as u64);
    assert_steps(imported, SCANS * READINGS);
}

/// The wheels made `steps` steps of a reading each, and all other lines are anchors.
fn assert_steps(imported: &Imported, steps: usize) {
    let report = &imported.report;
    let lines = (1 + SCANS * READINGS + SCANS) as u64;
    assert!(report.readings + report.anchors <= lines, "{report:?}");
    assert!((report.distance_m - 0.1 * steps as f64).abs() < 1e-9, "{report:?}");
    assert!(report.lateral_max_m < 1e-9, "{report:?}");
    // A step is a reading's, or nothing.
    for pair in imported.ticks.windows(2) {
        let step_m = odometry_delta(pair[0].ticks, pair[1].ticks, &WHEELS).x;
        assert!(step_m.abs() < 1e-5 || (step_m - 0.1).abs() < 1e-5, "{step_m}");
    }
}

#[test]
fn where_all_stamps_are_zero() {
    assert_echoes(&import_text(&corrected(|_| 0.0, |_, _| 0.0)).unwrap());
    // The first stray stamp comes late, or comes at once.
    for late in [0, SCANS / 2, SCANS - 1] {
        let echo_s = |scan, _| if scan == late { 4.6e-86 } else { 0.0 };
        assert_echoes(&import_text(&corrected(|_| 0.0, echo_s)).unwrap());
    }
}

#[test]
fn where_one_stamp_is_stray() {
    let stamp_s = |line| 100.0 + line as f64;
    for late in [0, SCANS - 1] {
        let echo_s = |scan, scan_s| if scan == late { 0.0 } else { scan_s };
        assert_echoes(&import_text(&corrected(stamp_s, echo_s)).unwrap());
    }
}

#[test]
fn where_the_stamps_are_those_of_the_scans() {
    let stamp_s = |line| 100.0 + line as f64;
    assert_echoes(&import_text(&corrected(stamp_s, |_, scan_s| scan_s)).unwrap());
}

/// The recording without the lines that `lost` names by their number behind a scan
/// (0: the scan, 1: its echo) and by the number of the scan; with `NEFF` lines behind
/// the echoes if `marks`.
fn without(text: &str, marks: bool, lost: impl Fn(usize, usize) -> bool) -> String {
    let (mut kept, mut scan, mut behind) = (String::new(), 0, 9);
    for line in text.lines() {
        (scan, behind) =
            if line.starts_with("FLASER") { (scan + 1, 0) } else { (scan, behind + 1) };
        if behind > 1 || !lost(behind, scan) {
            kept += &format!("{line}\n");
        }
        if behind == 1 && marks {
            kept += "NEFF 29.5\n\n";
        }
    }
    kept
}

#[test]
fn where_scans_or_their_echoes_were_deleted() {
    let (time_s, steps) = (|line| 100.0 + line as f64, SCANS * READINGS);
    // Of nine scans in ten only the echo is left.
    let thin = |behind, scan| behind == 0 && scan % 10 != 0;
    for stray_s in [0.0, 4.6e-86, f64::INFINITY, 7.25] {
        let text = corrected(time_s, |_, _| stray_s);
        let imported = import_text(&without(&text, false, thin)).unwrap();
        assert_eq!((imported.report.scans, imported.report.anchors), (2, SCANS as u64));
        assert_steps(&imported, steps);
    }
    // No stamp tells, but the line behind the echo does.
    let flat = corrected(|_| 0.0, |_, _| 0.0);
    assert_steps(&import_text(&without(&flat, true, thin)).unwrap(), steps);
    assert_steps(&import_text(&without(&flat, true, |behind, _| behind == 0)).unwrap(), steps);
    // The line before the mark may be a reading: a step is given up before and behind it.
    let text = corrected(time_s, |_, scan_s| scan_s);
    assert_steps(&import_text(&without(&text, true, |_, scan| scan == 7)).unwrap(), steps - 2);
    // An echo is missing.
    let text = corrected(time_s, |_, _| 0.0);
    for marks in [false, true] {
        let lost = |behind, scan| behind == 1 && scan == 7;
        assert_steps(&import_text(&without(&text, marks, lost)).unwrap(), steps - 1);
    }
}

#[test]
fn a_clock_that_is_set_or_rests_takes_nothing_from_the_odometry() {
    // Back by 90 s, ahead by two hours: at the 40th line, between two scans.
    for jump_s in [-90.0, 7200.0] {
        let stamp_s = |line| 100.0 + line as f64 + if line < 38 { 0.0 } else { jump_s };
        assert_echoes(&import_text(&corrected(stamp_s, |_, _| 0.0)).unwrap());
    }
}

#[test]
fn readings_that_repeat_a_scan_stay_readings() {
    // A robot that logs scan and odometry at one instant, and odometry between.
    let mut pose = SE2::identity();
    let mut text = odom(triple(pose), 100.0);
    for tick in 1..=40 {
        pose = pose.boxplus(&WHEELS.tangent(0.09, 0.11));
        let stamp_s = 100.0 + f64::from(tick);
        if tick % 2 == 0 {
            text += &flaser(30, triple(pose), triple(pose), stamp_s);
        }
        text += &odom(triple(pose), stamp_s);
    }
    let report = import_text(&text).unwrap().report;
    assert_eq!((report.anchors, report.readings, report.scans), (0, 41, 20));
    assert!((report.distance_m - 4.0).abs() < 1e-9, "{report:?}");
    // A robot that stands still, whatever the stamps.
    for stamp_s in [0.0, 50.0] {
        let stand = odom([1.0, 2.0, 0.5], stamp_s);
        let scan = flaser(30, [1.0, 2.0, 0.5], [1.0, 2.0, 0.5], stamp_s);
        let report = import_text(&(stand.clone() + &(scan + &stand).repeat(5))).unwrap().report;
        assert_eq!((report.anchors, report.readings), (0, 6), "{stamp_s}");
    }
}
