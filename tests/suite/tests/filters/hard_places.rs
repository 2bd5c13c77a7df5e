//! The built-in scenarios that are hard for a filter: none of them stops its robot, and
//! each shows what it is for.

use rusty_contract::Frame;
use rusty_sim::{Sim, StepOutcome};
use rusty_tests::*;

#[test]
fn no_wall_stops_the_robot_of_a_hard_place() {
    for scenario in ["long-corridor", "symmetric-rooms", "workshop", "warehouse"] {
        let mut sim = Sim::new(config_of(scenario, &["scan_every=0"])).unwrap();
        let (ticks, mut frame) = (sim.config().ticks, Frame::boxed());
        for seed in 0..40 {
            sim.restart(seed);
            let blocked =
                (0..ticks).filter(|_| sim.step(None, &mut frame) == StepOutcome::Blocked).count();
            assert_eq!(blocked, 0, "{scenario}, seed {seed}");
        }
    }
}

/// Ticks that the filter answers that is not told where it starts, for four seeds; the
/// one that is told is never lost.
fn answered_ticks(scenario: &str) -> Vec<u64> {
    let one = |seed: &str| {
        let place = folder();
        let args = [scenario, "--seed", seed, "--ticks", "500", "--without", "dead-reckoning"];
        let report = launch("hard", place.path(), &args);
        let error_m = number(score_of(&report, "mcl"), "final_position_error_m");
        assert!(error_m < 0.05, "{scenario}, seed {seed}: {error_m} m");
        let of_global = score_of(&report, "mcl-global");
        assert_eq!(number(of_global, "scored_ticks") + number(of_global, "unscored_ticks"), 500.0);
        number(of_global, "scored_ticks") as u64
    };
    ["0", "1", "2", "3"].map(one).to_vec()
}

#[test]
fn between_places_that_look_the_same_a_filter_does_not_decide() {
    for scenario in ["symmetric-rooms", "long-corridor"] {
        assert_eq!(answered_ticks(scenario), [0; 4], "{scenario}");
    }
}

#[test]
fn among_boxes_points_say_more_than_lines() {
    for seed in ["0", "1", "2", "3"] {
        let place = folder();
        let args = ["workshop", "--seed", seed, "--ticks", "600", "--without", "scan-match"];
        let report = launch("workshop", place.path(), &args);
        let ate_m = |name| number(score_of(&report, name), "ate_rmse_m");
        let (lines_m, points_m) = (ate_m("ekf"), ate_m("mcl"));
        assert!(lines_m > 3.0 * points_m, "seed {seed}: {lines_m} m and {points_m} m");
    }
}

#[test]
fn people_who_stand_around_a_robot_are_no_other_room() {
    for seed in ["10", "14", "34"] {
        let place = folder();
        let people = ["--set", "crowd.people=20", "--add", "mcl=mcl"];
        let args = [&["apartment", "--seed", seed, "--ticks", "1500"][..], &people].concat();
        let report = launch("crowd", place.path(), &args);
        let said = score_of(&report, "mcl");
        assert!(number(said, "scored_ticks") > 1350.0, "seed {seed}: {said}");
        assert_eq!(number(said, "wrong_ticks"), 0.0, "seed {seed}: {said}");
    }
}

#[test]
fn a_robot_that_people_stop_in_a_wrong_place_does_not_come_to_believe_it() {
    let place = folder();
    let scenario = filter_scenario("kidnapped.toml");
    let args = [scenario.as_str(), "--seed", "18", "--set", "crowd.people=10"];
    let report = launch("carried", place.path(), &args);
    let said = score_of(&report, "mcl");
    assert!(number(said, "wrong_ticks") < 100.0, "{said}");
}
