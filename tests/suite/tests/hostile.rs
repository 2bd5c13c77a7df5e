//! A hostile participant ends its own part and nobody else's.

use std::path::Path;

use rusty_tests::{binary, fresh_run, launch, sim_server, text};
use serde_json::Value;

const TICKS: &str = "60";

/// A run with a probe that misbehaves from tick 10 on.
fn with_probe(mode: &str, out: &Path) -> Value {
    let probe = format!("probe={} --mode {mode}", binary("probe-client").display());
    launch(mode, out, &["--ticks", TICKS, "--add", &probe, "--without", "score"])
}

#[test]
fn who_answers_for_others_changes_nothing() {
    let folder = rusty_tests::folder();
    let honest = with_probe("honest", &folder.path().join("honest"));
    let forged = with_probe("forge", &folder.path().join("forge"));
    assert_eq!(text(&forged, "digest"), text(&honest, "digest"));
    assert_eq!(forged["losses"], Value::Array(Vec::new()));
    for participant in forged["participants"].as_array().unwrap() {
        assert_eq!(participant["answers"], 60, "{participant}");
        assert_eq!(participant["strays"], 0, "{participant}");
    }
}

#[test]
fn who_sends_answers_without_end_keeps_nobody_waiting() {
    let folder = rusty_tests::folder();
    let honest = with_probe("honest", &folder.path().join("honest"));
    let flooded = with_probe("flood", &folder.path().join("flood"));
    assert_eq!(text(&flooded, "digest"), text(&honest, "digest"));
    assert_eq!(flooded["losses"], Value::Array(Vec::new()));
    let of = |name: &str| {
        let all = flooded["participants"].as_array().unwrap();
        all.iter().find(|p| p["name"] == name).unwrap()["strays"].as_u64().unwrap()
    };
    assert!(of("probe") > 100, "no flood came: {}", of("probe"));
    assert_eq!(of("dead-reckoning"), 0);
}

#[test]
fn who_names_another_process_is_refused() {
    let folder = rusty_tests::folder();
    let (out, run) = (folder.path().to_str().unwrap(), fresh_run("pid"));
    let probe = format!("probe={} --mode wrong-pid", binary("probe-client").display());
    let args = ["launch", "--run", run.as_str(), "--out", out, "--add", &probe];
    let ended = sim_server(&args).expect(1);
    assert!(ended.stderr.contains("it names process"), "{}", ended.stderr);
    rusty_tests::nothing_left(&run);
}
