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

/// Final errors of the filter that is not told where it starts, m, for four seeds; the
/// one that is told is never lost.
fn final_errors_m(scenario: &str) -> Vec<f64> {
    let one = |seed: &str| {
        let place = folder();
        let args = [scenario, "--seed", seed, "--ticks", "500", "--without", "dead-reckoning"];
        let report = launch("hard", place.path(), &args);
        let error_m = |name| number(score_of(&report, name), "final_position_error_m");
        assert!(error_m("mcl") < 0.05, "{scenario}, seed {seed}: {} m", error_m("mcl"));
        error_m("mcl-global")
    };
    ["0", "1", "2", "3"].map(one).to_vec()
}

#[test]
fn of_two_rooms_that_look_the_same_a_filter_takes_the_wrong_one() {
    let errors_m = final_errors_m("symmetric-rooms");
    // Never in between: at the robot, or at its image in the other room.
    assert!(errors_m.iter().all(|m| *m < 0.1 || *m > 5.0), "{errors_m:?}");
    assert!(errors_m.iter().any(|m| *m > 5.0), "{errors_m:?}");
}

#[test]
fn in_a_corridor_that_repeats_itself_a_filter_is_whole_periods_off() {
    let errors_m = final_errors_m("long-corridor");
    let off_m = |m: &f64| (m - 4.0 * (m / 4.0).round()).abs();
    assert!(errors_m.iter().all(|m| off_m(m) < 0.1), "{errors_m:?}");
    assert!(errors_m.iter().any(|m| *m > 3.0), "{errors_m:?}");
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
