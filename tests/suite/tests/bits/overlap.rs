//! The server makes the next tick while participants work on this one. No bit depends on it.

use rusty_contract::{OnLoss, Participant, Phase, Role};
use rusty_engine::run::RunBuilder;
use rusty_engine::scenario_file;
use rusty_engine::source::{Simulated, simulated_header};
use rusty_link::WaitPolicy;
use rusty_tests::*;

/// The run digest of a scenario with its estimators and its driver.
fn digest(scenario: &str, changes: &[&str], overlap: bool) -> [u8; 16] {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    let loaded = scenario_file::load(scenario, &changes).unwrap();
    let answering = |p: &Participant| matches!(p.role, Role::Estimator | Role::Driver);
    let mut roster = loaded.scenario.participants.clone();
    roster.retain(answering);
    for participant in &mut roster {
        participant.command[0] = binary(&participant.command[0]).display().to_string();
    }
    let header = simulated_header(loaded.config().unwrap(), roster, OnLoss::Abort);
    let ticks = header.config.ticks;
    let (mut source, out) = (Simulated::new(header).unwrap(), folder());
    let options = RunBuilder {
        overlap,
        join_timeout_s: 60.0,
        answer_timeout_s: 60.0,
        ..RunBuilder::new(fresh_run("overlap"), WaitPolicy::Balanced)
    };
    let outcome = options.build(&mut source, out.path()).unwrap().drive().unwrap();
    assert_eq!((outcome.phase, outcome.ticks), (Phase::Done, ticks), "{outcome:?}");
    outcome.digest.run()
}

#[test]
fn a_tick_that_is_made_early_is_the_same() {
    // With a script whole ticks are made early, with a driver the noise alone.
    let few = "ticks=120";
    let filters = repository().join("clients/filters/scenarios/filters.toml");
    for (scenario, changes) in [
        ("apartment", &[few, "scan_every=1"][..]),
        ("apartment", &[few, "scan_every=0"]),
        ("glass-lobby", &[few]),
        (arg(&filters), &[few, "scan_every=2"]),
    ] {
        let (early, in_order) = (digest(scenario, changes, true), digest(scenario, changes, false));
        assert_eq!(early, in_order, "{scenario} {changes:?}");
    }
}
