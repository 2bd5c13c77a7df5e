//! A hostile participant ends its own part and no other's.

use rusty_tests::*;

/// A run with a probe that misbehaves from tick 10 on.
fn with_probe(mode: &str, out: &Path) -> Value {
    let add = probe("probe", mode);
    launch(mode, out, &["--ticks", "60", "--add", &add, "--without", "score"])
}

#[test]
fn who_answers_for_others_changes_nothing() {
    let folder = folder();
    let honest = with_probe("honest", &folder.at("honest"));
    let forged = with_probe("forge", &folder.at("forge"));
    assert_eq!(text(&forged, "digest"), text(&honest, "digest"));
    assert_eq!(forged["losses"], json!([]));
    for participant in list(&forged, "participants") {
        assert_eq!(participant["answers"], 60, "{participant}");
        assert_eq!(participant["strays"], 0, "{participant}");
    }
}

#[test]
fn who_sends_answers_without_end_keeps_nobody_waiting() {
    let folder = folder();
    let honest = with_probe("honest", &folder.at("honest"));
    let flooded = with_probe("flood", &folder.at("flood"));
    assert_eq!(text(&flooded, "digest"), text(&honest, "digest"));
    assert_eq!(flooded["losses"], json!([]));
    let of = |name: &str| named(&flooded, "participants", name)["strays"].as_u64().unwrap();
    assert!(of("probe") > 100, "no flood came: {}", of("probe"));
    assert_eq!(of("dead-reckoning"), 0);
}

#[test]
fn who_names_another_process_is_refused() {
    let folder = folder();
    let add = probe("probe", "wrong-pid");
    run_to("pid", folder.path(), &["launch", "--add", &add]).expect(1).says("it names process");
}
