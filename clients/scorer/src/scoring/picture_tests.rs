//! Any trace can be drawn, and the picture says what it must.

use super::super::score;
use super::super::trace::tests::empty;
use super::*;
use crate::scoring::trace::Jump;
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
fn a_kidnapping_is_an_arrow_with_its_time_and_no_drive() {
    let mut trace = circle(&[], 1000);
    let to = |tick: usize| SE2::new(30.0 + tick as f64 * 1e-3, 0.0, 0.0);
    (500..1000).for_each(|tick| trace.truth[tick] = Some(to(tick)));
    trace.kidnapped_at = vec![500];
    // A solid line from one place to the other.
    let crossing = |text: &str| {
        let lines = text.split("<polyline").skip(1).map(|rest| rest.split("/>").next().unwrap());
        let solid = lines.filter(|line| !line.contains("dasharray"));
        let x = |point: &str| point.split(',').next().unwrap().parse::<f64>().unwrap();
        let far = |line: &&str| {
            let points = line.split("points=\"").nth(1).unwrap().split('"').next().unwrap();
            let all: Vec<f64> = points.split_whitespace().map(x).collect();
            all.windows(2).any(|pair| (pair[1] - pair[0]).abs() > 3000.0)
        };
        solid.filter(far).count()
    };
    let driven = drawn(&trace);
    let from = trace.truth[499].unwrap();
    trace.jumps = vec![Jump { tick: 500, time_s: 10.0, from, to: to(500) }];
    let carried = drawn(&trace);
    assert!(!driven.contains("kidnapping") && !driven.contains("\n10 s\n"));
    assert!(carried.contains("\nkidnapping\n") && carried.contains("\n10 s\n"));
    assert_eq!(crossing(&driven), crossing(&carried) + 1, "it drives from one to the other");
    assert_eq!(carried.matches("stroke-dasharray=\"25\"").count(), 2, "arrow and key");
}

#[test]
fn an_estimate_that_leaps_was_not_driven() {
    let mut trace = circle(&["a"], 1000);
    let lines = |trace: &RunTrace| drawn(trace).matches("<polyline").count();
    let before = lines(&trace);
    trace.estimates[0][500..].iter_mut().for_each(|pose| *pose = Some(SE2::new(-3.0, 1.0, 0.0)));
    assert!(lines(&trace) > before);
}

#[test]
fn a_recording_whose_time_stands_still_has_ticks_on_its_axis() {
    let mut trace = circle(&["a"], 1500);
    (trace.is_in_ticks, trace.seed) = (true, None);
    (0..1500).for_each(|tick| trace.time_s[tick] = tick as f64);
    let text = drawn(&trace);
    for part in ["\ntick\n", "\n1400\n", "scan at tick 1499", "A mark every 200 ticks"] {
        assert!(text.contains(part), "{part} is missing");
    }
    assert!(!text.contains("time (s)") && !text.contains("30.0 s"), "invented seconds");
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
