//! Any trace can be drawn, and the picture says what it must.

use super::super::score;
use super::super::trace::tests::empty;
use super::*;
use rusty_geometry::{SE2, trig};
use rusty_plot::png;

/// A circle of `ticks` ticks, with an estimate that drifts outwards.
fn circle(names: &[&str], ticks: u32) -> RunTrace {
    let mut trace = empty(names);
    for k in 1..=ticks {
        let angle_rad = f64::from(k) * 0.004;
        let at = |radius_m: f64| {
            let (s, c) = trig::sin_cos(angle_rad);
            Some(SE2::new(radius_m * c, radius_m * s, angle_rad + 1.57))
        };
        let drift = |i: usize| at(3.0 + 1e-4 * f64::from(k) * (i + 1) as f64);
        trace.push(f64::from(k) * 0.02, at(3.0), Some(&[2.0; 180]), (0..names.len()).map(drift));
    }
    trace
}

fn drawn(trace: &RunTrace) -> String {
    let text = svg(trace, &score(trace));
    assert!(!text.contains("NaN") && !text.contains("inf\""), "a number that is none");
    assert!(png(&text).unwrap().len() > 10_000);
    text
}

#[test]
fn a_picture_names_run_estimators_and_units() {
    let trace = circle(&["dead-reckoning", "particle-filter"], 1500);
    let text = drawn(&trace);
    for part in [
        "test · seed 42 · digest 0123456789ab\n",
        "1500 ticks · 30.0 s · 18.0 m driven",
        "dead-reckoning",
        "particle-filter",
        "x (m)",
        "y (m)",
        "position error (m)",
        "heading error, estimate − truth (deg)",
        "time (s)",
        "scan at 30.00 s",
        "0.150",
        "font-family=\"sans-serif\"",
    ] {
        assert!(text.contains(part), "{part} is missing");
    }
    assert_eq!(svg(&trace, &score(&trace)), text, "the same trace, other bytes");
}

#[test]
fn a_long_run_makes_no_long_file() {
    let text = drawn(&circle(&["a", "b"], 14_000));
    assert!(text.len() < 400_000, "{} bytes", text.len());
}

#[test]
fn whatever_there_is_is_drawn() {
    drawn(&empty(&[]));
    drawn(&empty(&["a"]));
    drawn(&circle(&["a"], 1));
    drawn(&circle(&[], 50));
    let mut blind = circle(&["a"], 50);
    blind.truth = vec![None; 50];
    let text = drawn(&blind);
    assert!(text.contains("no tick has both") && !text.contains("true path"));
}

#[test]
fn numbers_that_are_none_do_no_harm() {
    let mut trace = circle(&["a", "b"], 100);
    trace.estimates[0][10] = Some(SE2::new(f64::NAN, 1.0, 1.0));
    trace.estimates[0][11] = Some(SE2::new(1e308, -1e308, 1.0));
    trace.estimates[1][12] = Some(SE2::new(f64::INFINITY, 1.0, f64::NAN));
    trace.truth[13] = Some(SE2::new(f64::NAN, 1.0, 1.0));
    trace.time_s[14] = f64::NAN;
    trace.time_s[15] = f64::INFINITY;
    trace.last_scan = Some((99, vec![f64::NAN, f64::INFINITY, -1.0, 1e300, 2.0]));
    trace.scenario = "\u{0}<&>".repeat(40);
    assert!(drawn(&trace).contains("An estimate leaves the map."));
    trace.last_scan = Some((4711, vec![1.0]));
    trace.world.walls = vec![rusty_geometry::WallSpec {
        a: [f64::NAN, 0.0],
        b: [1.0, f64::INFINITY],
        material: rusty_geometry::Material::Glass,
    }];
    drawn(&trace);
}

#[test]
fn sixteen_estimators_fit() {
    let names: Vec<String> =
        (0..16).map(|i| format!("a-rather-long-name-of-estimator-{i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    drawn(&circle(&names, 300));
}
