//! `ekf` as a process: near the truth and right about how near, the same live,
//! from the log and on a replay, and with words where it cannot begin.

use std::path::{Path, PathBuf};

use rusty_tests::{Process, binary, filter_scenario, folder, fresh_run, launch, sim_server, text};
use serde_json::Value;

fn run(tag: &str, out: &Path, args: &[&str]) -> Value {
    launch(tag, out, &[&[filter_scenario("ekf.toml").as_str()][..], args].concat())
}

fn score_of<'a>(report: &'a Value, name: &str) -> &'a Value {
    let scores = report["scores"].as_array().unwrap();
    scores.iter().find(|score| text(score, "name") == name).unwrap()
}

#[test]
fn it_is_near_knows_how_near_and_says_the_same_again() {
    let place = folder();
    let out = place.path().join("run");
    let report = run("ekf", &out, &["--ticks", "700"]);
    let score = score_of(&report, "ekf");
    let figure = |key: &str| score[key].as_f64().unwrap();
    assert!(figure("ate_rmse_m") < 0.005, "{score}");
    assert!(figure("rmse_heading_error_rad") < 0.5_f64.to_radians(), "{score}");
    assert_eq!(score["nees"]["unusable"], 0);
    assert!(score["nees"]["mean"].as_f64().unwrap() < 6.0, "{score}");
    let surprise =
        score["nis"]["sum"].as_f64().unwrap() / score["nis"]["degrees"].as_f64().unwrap();
    assert!((0.9..1.1).contains(&surprise), "{score}");

    // Run again on the log, every answer is the same to the bit.
    let log = PathBuf::from(text(&report, "log"));
    let verdict = sim_server(&["verify", "--clients", "--json", log.to_str().unwrap()]);
    let verdict = verdict.expect(0).json();
    let others = verdict["clients"]["participants"].as_array().unwrap();
    let again = others.iter().find(|one| text(one, "name") == "ekf").unwrap();
    assert_eq!((&again["compared"], &again["equal"]), (&700.into(), &700.into()));
    // And so it is as a process of a replay.
    let (name, again) = (fresh_run("ekf-replay"), place.path().join("replay"));
    let args = ["--json", "--run", name.as_str(), "--out", again.to_str().unwrap()];
    let replayed = sim_server(&[&["replay", log.to_str().unwrap()][..], &args].concat());
    let replayed = replayed.expect(0).json();
    assert_eq!(replayed["digest"], report["digest"]);
}

#[test]
fn unequal_wheels_lose_dead_reckoning_but_not_the_filter() {
    let place = folder();
    // Open loop, such wheels would drive into a wall.
    let set =
        ["--set", "script.kind=truth-steered-patrol", "--set", "robot.radius_bias_right=0.01"];
    let args = [&["--ticks", "1000", "--without", "logger"][..], &set].concat();
    let report = run("ekf-bias", place.path(), &args);
    let error_m = |name: &str| score_of(&report, name)["ate_rmse_m"].as_f64().unwrap();
    assert!(error_m("ekf") < 0.01, "{}", error_m("ekf"));
    assert!(error_m("dead-reckoning") > 20.0 * error_m("ekf"), "{report}");
}

#[test]
fn without_a_map_it_predicts_and_without_a_start_it_says_what_to_do() {
    let place = folder();
    let text_of = std::fs::read_to_string(filter_scenario("ekf.toml")).unwrap();
    let (map, pose) = (place.path().join("map.toml"), place.path().join("pose.toml"));
    let with = |line: &str| {
        text_of.replacen("command = [\"ekf\"]", &format!("command = [\"ekf\"]\n{line}"), 1)
    };
    std::fs::write(&map, with("map = \"hidden\"")).unwrap();
    std::fs::write(&pose, with("initial_pose = \"hidden\"")).unwrap();

    let out = place.path().join("run");
    let report = launch("ekf-no-map", &out, &[map.to_str().unwrap(), "--ticks", "200"]);
    assert_eq!(
        score_of(&report, "ekf")["ate_rmse_m"],
        score_of(&report, "dead-reckoning")["ate_rmse_m"]
    );
    let on_log = ["--log", text(&report, "log"), "--name", "ekf"];
    let ended = Process::spawn(std::process::Command::new(binary("ekf")).args(on_log)).wait();
    let ended = ended.expect(0);
    assert!(ended.stderr.contains("there is no map with walls"), "{}", ended.stderr);

    let run = fresh_run("ekf-no-pose");
    let out = place.path().join("refused");
    let args = ["--ticks", "20", "--run", run.as_str(), "--out", out.to_str().unwrap()];
    let refused = sim_server(&[&["launch", pose.to_str().unwrap()][..], &args].concat());
    assert_ne!(refused.code, Some(0));
    assert!(refused.stderr.contains("is not told where the robot starts"), "{}", refused.stderr);
}
