//! What filters held possible is on the page where it came, in bounds, and
//! nowhere else.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use rusty_contract::{BeliefKind, WeightedPose};
use serde_json::json;

use super::tests::{data, page, run};
use crate::scoring::{BeliefKeeper, BeliefMoment};

/// Beliefs of these filters at every fifth of N ticks.
fn shown(names: &[&str], ticks: u64, poses: usize, kind: BeliefKind) -> BeliefKeeper {
    let mut keeper = BeliefKeeper::default();
    for tick in (0..ticks).step_by(5) {
        let pose = |k: usize| WeightedPose {
            x_m: 6.0 + 0.01 * tick as f64 + 1e-3 * k as f64,
            y_m: 2.0,
            theta_rad: 0.1 * k as f64 - 50.0,
            weight: if k == 0 { 0.5 } else { 0.5 / poses as f64 },
        };
        let poses: Vec<WeightedPose> = (0..poses).map(pose).collect();
        for name in names {
            let moment = BeliefMoment::of(tick, kind, poses.len() as u32, &poses);
            keeper.offer(name, moment);
        }
        keeper.close(tick + 1);
    }
    keeper
}

#[test]
fn a_page_says_whose_they_are_and_draws_the_latest() {
    let (header, mut trace) = run(&["one", "two"], 300);
    let without = page(&header, &trace);
    assert!(!without.contains("Arrowheads") && data(&without)["beliefs"] == json!([]));
    let mut keeper = shown(&["two"], 298, 3, BeliefKind::Histogram);
    keeper.offer("elsewhere", BeliefMoment::of(200, BeliefKind::Particles, 7, &[]));
    keeper.close(u64::MAX);
    trace.beliefs = keeper.finish(&trace.names);
    let text = page(&header, &trace);
    for part in [
        "<span>cells of two</span>",
        "<span>particles of elsewhere</span>",
        "for=\"tick\">two: cells 3, tick 295 · elsewhere: particles 7, tick 200</output>",
        "as received",
    ] {
        assert!(text.contains(part), "{part} is missing");
    }
    let beliefs = &data(&text)["beliefs"];
    assert_eq!([&beliefs[0]["estimator"], &beliefs[1]["estimator"]], [&json!(1), &json!(null)]);
    let bytes = BASE64_STANDARD.decode(beliefs[0]["poses"].as_str().unwrap()).unwrap();
    // The three poses of tick 295, the last of 60: 2 m and more to the right of 6 m.
    assert_eq!(bytes.len(), 60 * 3 * 6);
    let bounds_m = data(&text)["bounds_m"].clone();
    let bound = |k: usize| bounds_m[k].as_f64().unwrap();
    for (k, pose) in bytes[59 * 18..].chunks(6).enumerate() {
        let share = |at: usize| f64::from(u16::from_le_bytes([pose[at], pose[at + 1]])) / 65_535.0;
        let x_m = bound(0) + share(0) * (bound(2) - bound(0));
        let y_m = bound(1) + share(2) * (bound(3) - bound(1));
        let expected = 6.0 + 0.01 * 295.0 + 1e-3 * k as f64;
        assert!((x_m - expected).abs() < 1e-3 && (y_m - 2.0).abs() < 1e-3, "{x_m} {y_m}");
    }
    assert_eq!([bytes[59 * 18 + 5], bytes[59 * 18 + 11]], [255, 85], "a third as heavy");
}

#[test]
fn whatever_was_shown_a_page_grows_by_less_than_a_megabyte() {
    let names = ["a", "b", "c", "d", "e", "f", "g", "h"];
    for count in [1, 8] {
        let (header, mut trace) = run(&names[..count], 2000);
        let without = page(&header, &trace).len();
        let keeper = shown(&names[..count], 2000, 5000, BeliefKind::Particles);
        trace.beliefs = keeper.finish(&trace.names);
        let with = page(&header, &trace).len();
        assert!(with - without < 1 << 20, "{count}: {} bytes more", with - without);
    }
}

#[test]
fn poses_anywhere_do_no_harm() {
    let (header, mut trace) = run(&["a"], 50);
    let far = |x_m: f64, theta_rad: f64| WeightedPose { x_m, y_m: -x_m, theta_rad, weight: 1.0 };
    let poses = [far(1e300, 0.0), far(-1e30, 1e18), far(f64::MIN_POSITIVE, -1e-300)];
    let mut keeper = BeliefKeeper::default();
    keeper.offer("a", BeliefMoment::of(3, BeliefKind::Histogram, 3, &poses));
    keeper.close(4);
    trace.beliefs = keeper.finish(&trace.names);
    assert!(page(&header, &trace).contains("a: cells 3, tick 3"));
}
