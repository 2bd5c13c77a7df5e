//! Any run has a report, and nothing in it is run, fetched or left open.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use nalgebra::Vector3;
use rusty_contract::Estimate;
use rusty_contract::score::{ComputeTimes, Durations};
use rusty_geometry::SE2;

use super::*;
use crate::scoring::trace::tests::header;
use crate::scoring::trace::{Jump, Origin};
use crate::scoring::{TraceKeeper, score};

/// A covariance, row by row.
fn covariance(k: u32) -> [f64; 9] {
    let variance = 1e-4 + 1e-5 * f64::from(k);
    [variance, 0.0, 0.0, 0.0, 3.0 * variance, 0.0, 0.0, 0.0, variance]
}

/// A run of the first scenario's header: N estimators, each with
/// covariances if its number is even, along a circle.
pub(super) fn run(names: &[&str], ticks: u32) -> (LogHeader, RunTrace) {
    let mut header = header();
    let model = header.roster[0].clone();
    header.roster = names
        .iter()
        .map(|name| {
            let mut participant = model.clone();
            participant.name = (*name).to_owned();
            participant
        })
        .collect();
    header.config.ticks = u64::from(ticks);
    let mut keeper = TraceKeeper::new(&header);
    let start = SE2::new(6.0, 2.0, 0.0);
    let scan = vec![2.0; header.config.lidar.beams as usize];
    for k in 0..ticks {
        let truth = start.boxplus(&Vector3::new(0.01, 0.0, 0.005).scale(f64::from(k)));
        let estimate = |i: usize| {
            let off = Vector3::new(1e-4, -2e-4, 1e-4).scale(f64::from(k) * (i + 1) as f64);
            let pose = Estimate::from(truth.boxplus(&off));
            Some(Estimate { covariance: i.is_multiple_of(2).then(|| covariance(k)), ..pose })
        };
        let scan = (k % 5 == 4).then_some(&scan[..]);
        keeper.push(0.02 * f64::from(k + 1), Some(truth), scan, (0..names.len()).map(estimate));
    }
    let whole = Whole { ticks: ticks.into(), ticks_with_truth: ticks.into(), driven_m: 1.0 };
    let mut trace = keeper.finish(whole);
    trace.digest = "0123456789abcdef0123456789abcdef".to_owned();
    (header, trace)
}

fn report(trace: &RunTrace) -> ScoreReport {
    let times = Durations { p50_s: 2e-6, p99_s: 3e-5, max_s: 1e-3 };
    let mut scores = score(trace);
    if let Some(first) = scores.first_mut() {
        first.compute = Some(ComputeTimes { reported: times, observed: times });
    }
    trace.report(scores)
}

/// What the player has.
pub(super) fn data(page: &str) -> serde_json::Value {
    let (_, data) = page.split_once("id=\"data\">").unwrap();
    serde_json::from_str(data.split_once("</script>").unwrap().0).unwrap()
}

/// The page, with what must hold of every one.
pub(super) fn page(header: &LogHeader, trace: &RunTrace) -> String {
    let page = html(header, trace, &report(trace));
    assert_eq!(html(header, trace, &report(trace)), page, "the same run, other bytes");
    assert!(page.len() < 2 << 20, "{} bytes", page.len());
    for odd in ["NaN", "inf\"", "inf ", "undefined"] {
        assert!(!page.contains(odd), "{odd:?} is in it");
    }
    assert_eq!(page.matches("<script").count(), 2, "the data and what moves it");
    // The names of a policy and of a language are no addresses.
    let links = page.replace("<meta http-equiv=", "").replace("\"http://www.w3.org/2000/svg\"", "");
    let links = links.replace("url(#", "");
    for address in ["http", "://", "src=", "href=", "url(", "@import", "srcset="] {
        assert!(!links.contains(address), "{address}: somebody is asked");
    }
    let mut names: Vec<&str> =
        page.split(" id=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    let all = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), all, "two elements of one name");
    page
}

#[test]
fn seed_and_digest_come_first_and_every_part_is_there() {
    let (header, mut trace) = run(&["one", "two"], 300);
    let [started_utc, command] =
        ["2026-11-23 09:20", "sim-server launch -- <x>"].map(str::to_owned);
    trace.origin = Some(Origin { started_utc, command });
    let page = page(&header, &trace);
    let mut rest = page.split_once("<body>").unwrap().1;
    for part in [
        "<h1>apartment</h1>",
        "<dt>seed</dt><dd>42</dd>",
        "0123456789abcdef0123456789abcdef",
        "300 ticks",
        "2026-11-23 09:20 UTC",
        "<code>sim-server launch -- &lt;x&gt;</code>",
        "id=\"map\"",
        "id=\"tick\"",
        "id=\"position\"",
        "Bands: 95 %",
        "id=\"heading\"",
        "id=\"nees\"",
        "id=\"compute\"",
        "class=\"scores\"",
        "unscored",
        "id=\"data\"",
    ] {
        let found = rest.find(part).unwrap_or_else(|| panic!("{part} is missing, or not here"));
        rest = &rest[found..];
    }
}

#[test]
fn a_tick_of_a_recording_has_one_time() {
    let (header, mut trace) = run(&["a"], 50);
    trace.seed = None;
    let stamp_s = |tick: u64| 976_052_857.347_832 + 0.2 * tick as f64;
    trace.stops.iter_mut().for_each(|stop| stop.time_s = stamp_s(stop.tick));
    (0..50).for_each(|tick| trace.time_s[tick as usize] = stamp_s(tick));
    let page = page(&header, &trace);
    assert!(page.contains(" for=\"tick\">tick 49 · 9.80 s</output>"), "as drawn");
    // What the script says instead comes from here.
    let data = data(&page);
    assert_eq!((&data["times_s"][0], &data["times_s"][49]), (&0.0.into(), &9.8.into()));
    assert!(page.contains("time since the first tick (s)"));
    assert!(!page.contains("9760528"), "a time of day");
}

#[test]
fn names_are_shown_and_not_run() {
    let evil = "</title><script>alert(1)</script>\"'&<b>";
    let (mut header, mut trace) = run(&[evil], 20);
    header.writer = evil.to_owned();
    for name in [&mut trace.scenario, &mut trace.world.name] {
        *name = evil.to_owned();
    }
    let mut scores = report(&trace);
    scores.unscored = Some(evil.to_owned());
    let page = html(&header, &trace, &scores);
    for part in ["<script>", "</title><", "'&<", "&<b>"] {
        assert!(evil.contains(part) && !page.contains(part), "{part} is in the page");
    }
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt;"));
    assert_eq!(page.matches("<script").count(), 2);
}

#[test]
fn whatever_there_is_is_reported() {
    for (names, ticks) in [(&[][..], 0), (&[], 30), (&["a"], 0), (&["a"], 1), (&["a", "b"], 2)] {
        let (header, trace) = run(names, ticks);
        page(&header, &trace);
    }
    // No truth: nothing to compare with, but the paths are there.
    let (header, mut trace) = run(&["a"], 50);
    trace.truth.fill(None);
    trace.stops.iter_mut().for_each(|stop| stop.truth = None);
    let text = page(&header, &trace);
    assert!(text.contains("no tick has both") && text.contains("No tick has both a covariance"));
    // No scan, no covariance, no seed, no digest, no walls.
    let (header, mut trace) = run(&["a"], 50);
    for stop in &mut trace.stops {
        (stop.has_scan, stop.estimates[0].as_mut().unwrap().covariance) = (false, None);
        stop.ranges_m.clear();
    }
    (trace.last_scan, trace.seed) = (None, None);
    trace.digest.clear();
    trace.world.walls.clear();
    let text = page(&header, &trace);
    assert!(text.contains("No estimator of this run reported a covariance"));
    assert!(text.contains("<dd>none</dd>") && text.contains("not known"));
}

#[test]
fn numbers_that_are_none_do_no_harm() {
    let (header, mut trace) = run(&["a"], 60);
    let covariance = |trace: &mut RunTrace, tick: usize, p: [f64; 9]| {
        trace.stops[tick].estimates[0].as_mut().unwrap().covariance = Some(p);
    };
    covariance(&mut trace, 10, [f64::MAX; 9]);
    covariance(&mut trace, 11, [0.0; 9]);
    covariance(&mut trace, 12, [f64::NAN; 9]);
    covariance(&mut trace, 59, [1e12, 0.0, 0.0, 0.0, 1e12, 0.0, 0.0, 0.0, 1e12]);
    trace.stops[13].time_s = f64::NAN;
    trace.time_s[14] = f64::INFINITY;
    let far = SE2::new(1e300, -1e300, 1.0);
    trace.estimates[0][15] = Some(far);
    trace.stops[15].estimates[0] = Some(far.into());
    trace.stops[19].ranges_m = vec![f32::NAN, f32::INFINITY, -1.0, 1e30];
    page(&header, &trace);
}

#[test]
fn sixteen_estimators_for_long_make_no_large_file() {
    let names: Vec<String> =
        (0..16).map(|i| format!("a-rather-long-name-of-estimator-{i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let (header, trace) = run(&names, 9000);
    let text = page(&header, &trace);
    assert!(text.contains("ticks to look at"));
    assert_eq!(data(&text)["estimators"].as_array().unwrap().len(), 16);
}

#[test]
fn the_player_has_walls_poses_and_kidnappings_of_the_run() {
    let (header, mut trace) = run(&["one", "two"], 300);
    let [from, to] = [SE2::new(7.25, 2.5, 0.0), SE2::new(1.0, 2.0, 0.0)];
    trace.jumps = vec![Jump { tick: 100, time_s: 2.0, from, to }];
    let data = data(&page(&header, &trace));
    assert_eq!(data["jumps"], serde_json::json!([[100, "2 s", 7.25, 2.5, 1.0, 2.0]]));
    assert_eq!(data["walls"].as_array().unwrap().len(), trace.world.walls.len());
    let bytes = BASE64_STANDARD.decode(data["poses"].as_str().unwrap()).unwrap();
    let numbers: Vec<f32> =
        bytes.chunks(4).map(|four| f32::from_le_bytes(four.try_into().unwrap())).collect();
    assert_eq!(numbers.len(), 300 * (3 + 7 * 2));
    for (stop, row) in trace.stops.iter().zip(numbers.chunks(17)) {
        let origin = |k: usize| data["origin_m"][k].as_f64().unwrap();
        let truth = stop.truth.unwrap();
        let second = stop.estimates[1].unwrap().pose_in_world;
        for (pose, at) in [(truth, 0), (second, 10)] {
            let found = [0, 1].map(|k| f64::from(row[at + k]) + origin(k));
            assert!((found[0] - pose.x()).abs() < 1e-6 && (found[1] - pose.y()).abs() < 1e-6);
            assert!((f64::from(row[at + 2]) - pose.theta()).abs() < 1e-6);
        }
        // The second one reports no covariance.
        assert!(row[13..17].iter().all(|v| v.is_nan()) && row[6] > 0.0);
    }
}
