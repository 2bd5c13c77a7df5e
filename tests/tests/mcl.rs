//! `mcl` as a process: lost at the start, carried away, live and from a log.

use std::path::PathBuf;

use rusty_tests::{folder, fresh_run, launch, repository, sim_server, text};
use serde_json::Value;

fn scenario(name: &str) -> String {
    let path = repository().join("clients/filters/scenarios").join(name);
    path.to_str().unwrap().to_owned()
}

/// What the scorer says of `mcl`.
fn convergence(report: &Value) -> Value {
    let scores = report["scores"].as_array().unwrap();
    scores.iter().find(|s| text(s, "name") == "mcl").unwrap()["convergence"].clone()
}

#[test]
fn it_finds_itself_and_its_answers_come_again_from_log_and_replay() {
    let place = folder();
    let report = launch("global", place.path(), &[&scenario("global.toml"), "--ticks", "400"]);
    let found = convergence(&report);
    assert!(found["after_s"].as_f64().unwrap() < 3.0, "{found}");
    assert!(found["position_rmse_m"].as_f64().unwrap() < 0.01, "{found}");
    assert!(found["heading_rmse_rad"].as_f64().unwrap() < 0.01, "{found}");
    // Live, alone on the log, and in a replay: bit for bit the same answers.
    let log = PathBuf::from(text(&report, "log"));
    let verdict = sim_server(&["verify", "--clients", log.to_str().unwrap()]).expect(0);
    assert!(verdict.stdout.contains("400 answers of mcl"), "{verdict:?}");
    let (run, out) = (fresh_run("mcl-again"), place.path().join("again"));
    let args = ["--json", "--run", run.as_str(), "--out", out.to_str().unwrap()];
    let again = sim_server(&[&["replay", log.to_str().unwrap()][..], &args].concat()).expect(0);
    assert_eq!(text(&again.json(), "digest"), text(&report, "digest"));
}

#[test]
fn it_finds_itself_again_after_it_was_carried_away() {
    let place = folder();
    let args = [&scenario("kidnapped.toml"), "--ticks", "800"];
    let found = convergence(&launch("kidnapped", place.path(), &args));
    let recovered = found["recoveries"][0]["after_s"].as_f64().unwrap();
    assert!(recovered < 4.0, "{found}");
    assert!(found["position_rmse_m"].as_f64().unwrap() < 0.01, "{found}");
}
