//! `bayes-hallway` as a process: not told where it starts, it knows in the end,
//! and says the same again from the log.

use std::path::PathBuf;

use rusty_tests::{filter_scenario, folder, fresh_run, launch, sim_server, text};

#[test]
fn it_finds_itself_by_the_doors_and_says_the_same_again() {
    let place = folder();
    let report = launch("hallway", place.path(), &[&filter_scenario("hallway.toml")]);
    let score = &report["scores"].as_array().unwrap()[0];
    assert!(score["final_position_error_m"].as_f64().unwrap() < 0.25, "{score}");
    assert!(score["final_heading_error_deg"].as_f64().unwrap() < 3.0, "{score}");
    assert_eq!(score["nees"]["unusable"], 0);

    let log = PathBuf::from(text(&report, "log"));
    let verdict = sim_server(&["verify", "--clients", "--json", log.to_str().unwrap()]);
    let verdict = verdict.expect(0).json();
    let again = &verdict["clients"]["participants"][0];
    assert_eq!((&again["compared"], &again["equal"]), (&1000.into(), &1000.into()));
    // And as a client of a replay.
    let (run, out) = (fresh_run("hallway-again"), place.path().join("again"));
    let args = ["--json", "--run", run.as_str(), "--out", out.to_str().unwrap()];
    let again = sim_server(&[&["replay", log.to_str().unwrap()][..], &args].concat()).expect(0);
    assert_eq!(text(&again.json(), "digest"), text(&report, "digest"));
}
