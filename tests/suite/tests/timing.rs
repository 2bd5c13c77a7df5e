//! Modelled compute time: late answers take effect late, in every repetition
//! of the run, and whoever is late is judged as late as it is.

use std::fs;

use rusty_tests::*;
use serde_json::Value;

const TICKS: &str = "ticks = 300\nseed = 9\n";
const WITNESSES: &str = "
[[participant]]
name = \"score\"
role = \"scorer\"
command = [\"score\"]

[[participant]]
name = \"logger\"
role = \"logger\"
command = [\"logger\"]
";

/// A run of a scenario with these lines; its report, and the folder.
fn run(tag: &str, scenario: &str) -> (Value, tempfile::TempDir) {
    let out = folder();
    let file = out.path().join("scenario.toml");
    fs::write(&file, format!("{TICKS}{scenario}{WITNESSES}")).unwrap();
    (launch(tag, &out.path().join("run"), &[file.to_str().unwrap()]), out)
}

fn estimator(name: &str, compute: &str) -> String {
    format!("\n[[participant]]\nname = \"{name}\"\ncommand = [\"dead-reckoning\"]\n{compute}\n")
}

fn driver(compute: &str) -> String {
    let script = "start = { x_m = 6.0, y_m = 4.5, theta_rad = 0.0 }\n[script]\nkind = \"driver\"\n";
    format!(
        "{script}[[participant]]\nname = \"bouncer\"\nrole = \"driver\"\n\
         command = [\"03_driver\"]\n{compute}\n"
    )
}

#[test]
fn a_late_estimate_is_judged_as_late_as_it_is() {
    let late = estimator("late", "compute = { answer_s = 0.1, scan_s = 0.04, budget_s = 0.12 }");
    let roster = estimator("prompt", "") + &late;
    let (report, _out) = run("late", &roster);
    let mean = |i: usize| report["scores"][i]["mean_position_error_m"].as_f64().unwrap();
    // Both say the same; one of them says it five ticks or more too late.
    assert!(mean(1) > 1.2 * mean(0), "{} and {} m", mean(0), mean(1));
    let timing = &report["timings"];
    assert_eq!(timing.as_array().unwrap().len(), 1, "{timing}");
    assert_eq!((text(&timing[0], "name"), &timing[0]["latest_ticks"]), ("late", &7.into()));
    // A scan every five ticks.
    assert_eq!(timing[0]["overruns"], 60);
    // The answers themselves, and so the digest, are those of a prompt one.
    let (same, _out) = run("prompt", &(estimator("prompt", "") + &estimator("late", "")));
    assert_eq!(report["digest"], same["digest"]);
    assert_eq!(same["timings"], Value::Array(vec![]));
    assert_eq!(
        same["scores"][0]["mean_position_error_m"],
        same["scores"][1]["mean_position_error_m"]
    );
}

#[test]
fn a_late_driver_drives_otherwise_and_always_the_same() {
    let compute = "compute = { answer_s = 0.1, budget_s = 0.05 }";
    let (prompt, _out) = run("prompt", &driver(""));
    let (late, out) = run("late", &driver(compute));
    assert_ne!(late["world_digest"], prompt["world_digest"]);
    assert_eq!(late["timings"][0]["overruns"], 300);
    let (again, _again) = run("again", &driver(compute));
    assert_eq!(late["digest"], again["digest"]);
    // Who simulates the log again, or replays it, knows of the delay as well.
    let log = out.path().join("run/run.log");
    let log = log.to_str().unwrap();
    let verdict = sim_server(&["verify", log, "--clients", "--json"]).expect(0).json();
    assert_eq!((&verdict["bit_exact"], &verdict["digest"]), (&true.into(), &late["digest"]));
}

#[test]
fn only_those_whose_answers_count_have_a_compute_time() {
    let out = folder();
    let file = out.path().join("scenario.toml");
    let scorer = "[[participant]]\nname = \"s\"\nrole = \"scorer\"\ncompute = { answer_s = 1.0 }\n";
    fs::write(&file, scorer).unwrap();
    let ended = sim_server(&["launch", file.to_str().unwrap()]).expect(2);
    assert!(ended.stderr.contains("participant[0].compute"), "{ended:#?}");
}
