//! `mcl` as a process: lost at the start, carried away, live and from a log.

use std::path::PathBuf;

use rusty_filters::OccupancyMap;
use rusty_geometry::apartment;
use rusty_tests::{real_data, folder, fresh_run, launch, repository, sim_server, text};
use serde_json::Value;

fn scenario(name: &str) -> String {
    let path = repository().join("clients/filters/scenarios").join(name);
    path.to_str().unwrap().to_owned()
}

/// What the scorer says of `mcl`.
fn convergence(report: &Value) -> Value {
    score(report, "mcl")["convergence"].clone()
}

/// What it says of a participant.
fn score<'a>(report: &'a Value, name: &str) -> &'a Value {
    let scores = report["scores"].as_array().unwrap();
    scores.iter().find(|s| text(s, "name") == name).unwrap()
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

#[test]
fn a_map_of_cells_and_the_beam_model_serve_as_processes() {
    let place = folder();
    let stem = place.path().join("cells");
    OccupancyMap::of_world(&apartment(), 0.2, 0.05).save(&stem).unwrap();
    let on_cells = format!("--add=on-cells=mcl --global --map {}.yaml", stem.display());
    let with_rays = "--add=with-rays=mcl --model beam --particles 500 --particles-min 300";
    let out = place.path().join("run");
    let args = [&scenario("global.toml"), "--ticks", "300", &on_cells, with_rays];
    let report = launch("maps", &out, &args);
    for (name, most_m) in [("on-cells", 0.06), ("with-rays", 0.02)] {
        let said = score(&report, name);
        assert!(said["final_position_error_m"].as_f64().unwrap() < most_m, "{name}: {said}");
        assert_eq!(said["nees"]["unusable"], 0, "{name}: {said}");
    }
}
