//! Modelled compute time: late answers take effect late, in every repetition
//! of the run, and a participant that is late is judged as late as it is.

use rusty_tests::*;

const TICKS: &str = "ticks = 300\nseed = 9\n";
/// A run of a scenario with these lines; its report, and the folder.
fn run(tag: &str, scenario: &str) -> (Value, Folder) {
    let out = folder();
    let file = out.write("scenario.toml", format!("{TICKS}{scenario}{RECORDERS}"));
    (launch(tag, &out.at("run"), &[&file]), out)
}

fn reckoning(name: &str, compute: &str) -> String {
    estimator(name, &["dead-reckoning"], compute)
}

fn driver(compute: &str) -> String {
    let script = "start = { x_m = 6.0, y_m = 4.5, theta_rad = 0.0 }\n[script]\nkind = \"driver\"\n";
    let lines = format!("role = \"driver\"\n{compute}");
    format!("{script}{}", estimator("bouncer", &["03_driver"], &lines))
}

#[test]
fn a_late_estimate_is_judged_as_late_as_it_is() {
    let late = reckoning("late", "compute = { answer_s = 0.1, scan_s = 0.04, budget_s = 0.12 }");
    let roster = reckoning("prompt", "") + &late;
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
    let (same, _out) = run("prompt", &(reckoning("prompt", "") + &reckoning("late", "")));
    assert_eq!(report["digest"], same["digest"]);
    assert_eq!(same["timings"], json!([]));
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
    let log = out.at("run/run.log");
    let verdict = about("verify", &log, &["--clients", "--json"]).expect(0).json();
    assert_eq!((&verdict["bit_exact"], &verdict["digest"]), (&true.into(), &late["digest"]));
}

#[test]
fn only_those_whose_answers_count_have_a_compute_time() {
    let out = folder();
    let scorer = "[[participant]]\nname = \"s\"\nrole = \"scorer\"\ncompute = { answer_s = 1.0 }\n";
    let file = out.write("scenario.toml", scorer);
    sim_server(&["launch", &file]).expect(2).says("participant[0].compute");
}
