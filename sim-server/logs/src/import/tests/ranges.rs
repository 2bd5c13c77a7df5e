//! Codes for *no return*, and maxima that are too small.

use std::fmt::Write as _;

use rusty_contract::log::Finding;

use super::{import_text, odom};

const BEAMS: usize = 60;

/// A robot that moves in each of 30 scans (unless it `stands`), with ranges that
/// thin out up to `longest_m`; one beam in ten has one of the `codes` instead.
fn scans(parameter: &str, longest_m: f64, codes: &[f64], stands: bool) -> String {
    let mut text = parameter.to_owned() + &odom([0.0; 3], 0.0);
    for scan in 1..=30_usize {
        let x_m = if stands { 0.0 } else { 0.5 * scan as f64 };
        text += &odom([x_m, 0.0, 0.0], scan as f64);
        write!(text, "FLASER {BEAMS}").unwrap();
        for beam in 0..BEAMS {
            let spread = ((scan * 37 + beam * 11) % 101) as f64 / 100.0;
            let measured_m = longest_m * spread * spread;
            let code = (beam % 10 == 3).then(|| codes.get((scan + beam / 10) % codes.len().max(1)));
            let range_m = code.flatten().copied().unwrap_or(measured_m);
            write!(text, " {range_m:.3}").unwrap();
        }
        let stamp_s = scan as f64 + 0.5;
        writeln!(text, " {x_m} 0 0 {x_m} 0 0 {stamp_s} host {stamp_s}").unwrap();
    }
    text
}

/// The maximum, how many ranges are doubted beyond the recording's own, and
/// whether all is said in the log, too.
fn max_of(text: &str) -> (f64, Option<u64>) {
    let imported = import_text(text).unwrap();
    assert_eq!(imported.header.findings(), imported.report.findings);
    let doubted = imported.report.findings.iter().find_map(|finding| match finding {
        Finding::RangeMaxDoubted { exceeding, used_m, ranges, .. } => {
            assert_eq!(*used_m, imported.header.config.lidar.range_max_m);
            assert_eq!(*ranges, 30 * BEAMS as u64);
            Some(*exceeding)
        }
        _ => None,
    });
    (imported.header.config.lidar.range_max_m, doubted)
}

#[test]
fn values_that_repeat_too_often_at_the_top_are_codes() {
    for (longest_m, codes, expected_m) in [
        (40.0, &[51.15, 51.14, 51.1, 51.16][..], 51.1),
        (30.0, &[32.763, 32.767, 32.759], 32.759),
        (7.5, &[8.191, 8.187], 8.187),
        (75.0, &[81.91, 81.83], 81.83),
        (20.0, &[99.0], 99.0),
    ] {
        assert_eq!(max_of(&scans("", longest_m, codes, false)), (expected_m, None));
    }
    // Without codes the largest range is measured.
    assert_eq!(max_of(&scans("", 40.0, &[], false)), (40.0, None));
}

#[test]
fn a_far_wall_before_a_robot_that_stands_is_not_a_code() {
    // Its noise is as narrow as the codes of some lasers.
    let text = scans("", 5.0, &[7.52, 7.53, 7.51], true);
    assert_eq!(max_of(&text).0, 7.53);
}

#[test]
fn a_maximum_that_many_ranges_exceed_is_doubted() {
    let parameter = |m: f64| format!("PARAM robot_front_laser_max {m} nohost 0\n");
    let codes = &[51.15, 51.1][..];
    let (max_m, doubted) = max_of(&scans(&parameter(10.0), 40.0, codes, false));
    // Half of the 1620 measured ranges are longer than a quarter of the longest.
    assert_eq!(max_m, 51.1);
    assert!((700..=920).contains(&doubted.unwrap()), "{doubted:?}");
    let (max_m, doubted) = max_of(&scans(&parameter(10.0), 40.0, &[], false));
    assert_eq!((max_m, doubted.is_some()), (40.0, true));
    // One that only codes exceed holds; one beyond the codes does not count.
    assert_eq!(max_of(&scans(&parameter(50.0), 40.0, codes, false)), (50.0, None));
    assert_eq!(max_of(&scans(&parameter(90.0), 40.0, codes, false)), (51.1, None));
    assert_eq!(max_of(&scans(&parameter(90.0), 40.0, &[81.91], false)), (81.83, None));
    assert_eq!(max_of(&scans(&parameter(90.0), 40.0, &[], false)), (90.0, None));
}
