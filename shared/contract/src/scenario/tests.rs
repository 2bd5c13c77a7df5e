//! Tests of the scenario file.

use super::*;
use crate::sandbox::Sandbox;

#[test]
fn an_empty_file_is_the_default_run() {
    assert_eq!(Scenario::from_toml("").unwrap(), Scenario::default());
}

#[test]
fn a_scenario_survives_its_text() {
    let scenario = Scenario::default();
    let text = toml::to_string(&scenario).unwrap();
    assert_eq!(Scenario::from_toml(&text).unwrap(), scenario, "{text}");
}

#[test]
fn a_participant_that_asks_for_no_sandbox_is_written_as_before_there_was_one() {
    let json = |p: &Participant| serde_json::to_string(p).unwrap();
    let mut participant = Participant::new("a", Role::Estimator);
    assert!(!json(&participant).contains("sandbox") && !json(&participant).contains("files"));
    assert_eq!(serde_json::from_str::<Participant>(&json(&participant)).unwrap(), participant);
    participant.sandbox = Sandbox::Required;
    participant.files = vec!["model.bin".to_owned()];
    assert_eq!(serde_json::from_str::<Participant>(&json(&participant)).unwrap(), participant);
}

#[test]
fn a_seed_that_toml_has_no_integer_for_is_text() {
    for seed in [0, 42, i64::MAX as u64, 1 << 63, u64::MAX] {
        let text = toml::to_string(&Scenario { seed, ..Scenario::default() }).unwrap();
        assert_eq!(Scenario::from_toml(&text).unwrap().seed, seed, "{text}");
        assert_eq!(text.contains(&format!("seed = {seed}\n")), seed < 1 << 63, "{text}");
    }
}

#[test]
fn what_is_wrong_is_named() {
    for (text, expected) in [
        ("sede = 1", "unknown field `sede`"),
        ("sede = 1", "did you mean \"seed\"?"),
        ("[kidnapping]\ntick = 5", "write [[kidnapping]]"),
        ("[participant]\nname = \"a\"", "write [[participant]]"),
        ("seed = -1", "seed"),
        ("seed = \"x\"", "a whole number from 0"),
        ("ticks = 0", "ticks = 0: is out of range"),
        ("dt_s = \"fast\"", "dt_s"),
        ("[robot]\nslip_std = nan", "robot.slip_std = NaN: is not a number"),
        ("[robot]\nslip = 0.1", "unknown field `slip`"),
        ("[lidar]\nbeams = 5000", "lidar.beams = 5000: is out of range"),
        ("[script]\nkind = \"waltz\"", "waltz"),
        ("[script]\nkind = \"driver\"", "role = \"driver\""),
        ("[script]\nkind = \"straight\"\nv_m_s = inf", "script.v_m_s = inf"),
        ("[[participant]]\nname = \"a\"\n[[participant]]\nname = \"a\"", "is there twice"),
        ("[[participant]]\nname = \"a/b\"", "another character"),
        ("[[participant]]\nname = \"a\"\nrole = \"king\"", "king"),
        ("on_loss = \"panic\"", "panic"),
        ("[[participant]]\nname = \"s\"\nrole = \"scorer\"\nrequired = false", "cannot be false"),
        ("answer_timeout_s = 0", "answer_timeout_s = 0"),
        (
            "[[kidnapping]]\ntick = 5\nto = { x_m = inf, y_m = 0.0, theta_rad = 0.0 }",
            "kidnapping[0].to.x_m = inf: is out of range",
        ),
        ("[[participant]]\nname = \"a\"\nsandbox = \"maybe\"", "no sandbox"),
        (
            "[[participant]]\nname = \"s\"\nrole = \"scorer\"\nsandbox = true",
            "participant[0].sandbox = required: cannot be had by a scorer",
        ),
    ] {
        let error = Scenario::from_toml(text).unwrap_err().to_string();
        assert!(error.contains(expected), "{text:?} gave {error}");
    }
}
