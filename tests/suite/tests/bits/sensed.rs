//! The small sensors: every way to repeat a run repeats their readings, and what
//! differs in one is named.

use rusty_tests::*;

#[test]
fn a_run_with_every_small_sensor_is_verified_replayed_and_compared() {
    let place = folder();
    let scenario = sensed_scenario(place.path(), "all.toml", "imu = {}");
    let report = launch("sensed", &place.at("run"), &[&scenario]);
    let log = log_of(&report);
    let verdict = about("verify", &log, &["--clients", "--json"]).expect(0).json();
    assert_eq!((&verdict["bit_exact"], &verdict["digest"]), (&true.into(), &report["digest"]));
    let again = replay(&log, &place.at("again"), &[]).expect(0).json();
    assert_eq!(again["digest"], report["digest"]);

    let info = about("info", &log, &["--json"]).expect(0).json();
    assert_eq!((&info["readings"]["imu"], &info["readings"]["sonars"]), (&json!(80), &json!(27)));
    let blocked = about("info", &log, &["--tick", "79", "--json"]).expect(0).json();
    assert_eq!(blocked["readings"]["bumper"], 4.0, "{blocked}");

    // The first thing that differs without the IMU is that it is not there.
    let scenario = sensed_scenario(place.path(), "fewer.toml", "");
    let other = log_of(&launch("fewer", &place.at("fewer"), &[&scenario]));
    let found = sim_server(&["diff", arg(&log), arg(&other), "--json"]).expect(4);
    assert!(found.stdout.contains("\"readings\""), "{}", found.stdout);
}
