//! Findings: each where it is due, none on a sound recording, and refused where
//! the import is strict.

use rusty_contract::log::Finding;
use rusty_geometry::SE2;

use super::super::wheels::WHEELS;
use super::{ImportError, ImportOptions, Imported, flaser, import_carmen, import_text, odom};

fn triple(pose: SE2) -> [f64; 3] {
    [pose.x(), pose.y(), pose.theta()]
}

/// A robot that drives 0.1 m a second along an arc; every fifth line is a scan
/// with its echo. No odometry is logged where `is_lost` for the second.
fn drive(stamp_s: impl Fn(u32) -> f64, is_lost: impl Fn(u32) -> bool) -> String {
    let mut pose = SE2::identity();
    let mut text = odom(triple(pose), stamp_s(0));
    for second in 1..=100 {
        pose = pose.boxplus(&WHEELS.tangent(0.09, 0.11));
        if !is_lost(second) {
            text += &odom(triple(pose), stamp_s(second));
        }
        if second % 5 == 0 {
            text += &flaser(30, triple(pose), triple(pose), stamp_s(second));
            text += &odom(triple(pose), 1e-42);
        }
    }
    text
}

fn findings(text: &str) -> Vec<Finding> {
    let Imported { report, header, .. } = import_text(text).unwrap();
    assert_eq!(header.findings(), report.findings);
    let said = report.to_string();
    assert!(report.findings.iter().all(|f| said.contains(&f.to_string())), "{said}");
    report.findings
}

#[test]
fn a_sound_recording_has_none() {
    assert_eq!(findings(&drive(f64::from, |_| false)), []);
    assert_eq!(findings(&odom([0.0; 3], 1.0)), []);
}

#[test]
fn intervals_between_scans_without_odometry() {
    let found = findings(&drive(f64::from, |second| (41..=45).contains(&second)));
    let [Finding::NoOdometry { missing, intervals, line, turn_rad, distance_m, gap_s }] = found[..]
    else {
        panic!("{found:?}");
    };
    // 1 line, 5 + 2 for each of 8 scans, and the scan.
    assert_eq!((missing, intervals, line, gap_s), (1, 19, 1 + 8 * 7 + 1, Some(5.0)));
    assert!((turn_rad - 5.0 * 0.02 / WHEELS.track_m).abs() < 1e-9, "{turn_rad}");
    assert!((distance_m - 0.5).abs() < 0.01, "{distance_m}");
    // Where the odometry stands still, nothing is missing.
    let stands = odom([0.0; 3], 0.0) + &flaser(30, [0.0; 3], [0.0; 3], 1.0);
    assert_eq!(findings(&(stands + &flaser(30, [0.0; 3], [0.0; 3], 2.0))), []);
}

#[test]
fn odometry_that_covers_a_fraction_of_the_path() {
    let found = findings(&drive(f64::from, |second| second > 5));
    let Some(Finding::ShortOdometry { odometry_m, path_m }) = found.get(1) else {
        panic!("{found:?}");
    };
    assert!((odometry_m - 0.5).abs() < 1e-6 && (path_m - 9.5).abs() < 0.1, "{found:?}");
}

#[test]
fn stamps_that_stand_still_are_replaced_everywhere() {
    let changes_once = |second| if second < 50 { 1.13486e9 } else { 1.13487e9 };
    for stamp_s in [|_| 0.0, changes_once] {
        let imported = import_text(&drive(stamp_s, |_| false)).unwrap();
        let report = &imported.report;
        let [Finding::FlatStamps { standing, intervals: 19, nominal_rate_hz: 10.0 }] =
            report.findings[..]
        else {
            panic!("{report:?}");
        };
        assert!(standing >= 18, "{standing}");
        assert_eq!((report.ticks, report.anchors, report.stamps_backwards), (121, 20, 0));
        let dt_s = imported.header.config.dt_s;
        assert_eq!((dt_s, report.dt_s, report.first_stamp_s), (0.1, 0.1, 0.1));
        assert_eq!(report.last_stamp_s, 121.0 * 0.1);
        for (tick, number) in imported.ticks.iter().zip(1..) {
            assert_eq!((tick.stamp_s, tick.time_s(dt_s)), (None, f64::from(number) * dt_s));
        }
    }
}

#[test]
fn time_that_runs_backwards() {
    let back = |second: u32| 1000.0 - f64::from(second);
    let found = findings(&drive(back, |_| false));
    let [Finding::BackwardStamps { backwards, ticks, max_s, .. }] = found[..] else {
        panic!("{found:?}");
    };
    assert_eq!((backwards, ticks, max_s), (100, 121, 1.0));
    // Once in a while two messages change places.
    let once = |from: u32, back_s: f64| {
        let stamp_s =
            move |second: u32| f64::from(second) - if second == from { back_s } else { 0.0 };
        findings(&drive(stamp_s, |_| false)).len()
    };
    assert_eq!([once(30, 2.5), once(30, 9.0)], [0, 1]);
}

#[test]
fn motion_to_the_side() {
    let step = |x_m: f64, y_m: f64, stamp_s| odom([x_m, y_m, 0.0], stamp_s);
    let found = findings(&(step(0.0, 0.0, 1.0) + &step(1.0, 0.3, 2.0) + &step(2.0, 0.0, 3.0)));
    let [Finding::Sideways { total_m, odometry_m, max_m, line: 2 }] = found[..] else {
        panic!("{found:?}");
    };
    assert!((total_m - 0.6).abs() < 1e-9 && (max_m - 0.3).abs() < 1e-9, "{found:?}");
    assert!((odometry_m - 2.0).abs() < 1e-9, "{found:?}");
}

#[test]
fn a_strict_import_refuses_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("a.log"), folder.path().join("a.runlog"));
    let strict = ImportOptions { writer: "test", strict: true };
    std::fs::write(&input, drive(|_| 0.0, |_| false)).unwrap();
    let refused = import_carmen(&input, &output, strict, &mut |_| ()).unwrap_err();
    let ImportError::Strict { findings, .. } = &refused else { panic!("{refused}") };
    assert!(matches!(findings[..], [Finding::FlatStamps { .. }]), "{findings:?}");
    assert!(refused.to_string().contains(&findings[0].to_string()), "{refused}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    std::fs::write(&input, drive(f64::from, |_| false)).unwrap();
    import_carmen(&input, &output, strict, &mut |_| ()).unwrap();
}
