//! The filters of landmarks as processes: on a loop, with identities and without, over
//! several seeds.

use rusty_contract::Frame;
use rusty_sim::{Sim, StepOutcome};
use rusty_tests::*;

const SEEDS: usize = 5;

/// A sweep of `landmarks.toml`: one round and a quarter.
fn sweep(place: &Folder, set: &[&str]) -> Table {
    let (csv, scenario) = (place.at("table.csv"), filter_scenario("landmarks.toml"));
    let seeds = format!("0..{SEEDS}");
    let args = ["sweep", &scenario, "--seeds", &seeds, "--clients", "--ticks", "2000", "--quiet"];
    let set: Vec<&str> = set.iter().flat_map(|set| ["--set", set]).collect();
    sim_server(&[&args[..], &["--out", arg(&csv)], &set].concat()).expect(0);
    Table::read(&csv)
}

/// The numbers of an estimator in a column, one for each seed.
fn of(table: &Table, estimator: &str, column: &str) -> Vec<f64> {
    let rows = table.column("estimator").into_iter().zip(table.column(column));
    let numbers = rows.filter(|(name, _)| *name == estimator).map(|(_, v)| v.parse().unwrap());
    let numbers: Vec<f64> = numbers.collect();
    assert_eq!(numbers.len(), SEEDS, "{estimator}");
    numbers
}

fn rms(numbers: &[f64]) -> f64 {
    (numbers.iter().map(|v| v * v).sum::<f64>() / numbers.len() as f64).sqrt()
}

fn mean(numbers: &[f64]) -> f64 {
    numbers.iter().sum::<f64>() / numbers.len() as f64
}

/// The errors of all filters are a part of those of the wheels, m.
#[track_caller]
fn beats_the_wheels(table: &Table, least_m: f64) {
    let wheels_m = rms(&of(table, "dead-reckoning", "ate_rmse_m"));
    assert!(wheels_m > least_m, "{wheels_m} m");
    for (name, factor) in
        [("ekf-landmarks", 8.0), ("ekf-slam", 3.0), ("fastslam-1", 3.0), ("fastslam", 3.0)]
    {
        let filter_m = rms(&of(table, name, "ate_rmse_m"));
        assert!(factor * filter_m < wheels_m, "{name}: {filter_m} m, wheels {wheels_m} m");
    }
}

#[test]
fn no_wall_stops_the_robot() {
    for bias in ["0.0", "0.01"] {
        let set = format!("robot.radius_bias_right={bias}");
        let config = config_of(&filter_scenario("landmarks.toml"), &[&set]);
        let (ticks, mut sim, mut frame) = (config.ticks, Sim::new(config).unwrap(), Frame::boxed());
        for seed in 0..40 {
            sim.restart(seed);
            let stopped = (0..ticks).any(|_| sim.step(None, &mut frame) == StepOutcome::Blocked);
            assert!(!stopped, "bias {bias}, seed {seed}");
        }
    }
}

#[test]
fn on_a_loop_all_are_better_than_the_wheels_and_sure_as_they_are_exact() {
    for identity in ["given", "hidden"] {
        let place = folder();
        let table = sweep(&place, &[&format!("sensors.landmarks.identity={identity}")]);
        beats_the_wheels(&table, 0.2);
        // The wheels slip as the filter expects: 3 on average over the runs.
        let nees = mean(&of(&table, "ekf-landmarks", "nees_mean"));
        assert!((2.0..4.0).contains(&nees), "{identity}: {nees}");
        let nees = mean(&of(&table, "ekf-slam", "nees_mean"));
        assert!((1.0..8.0).contains(&nees), "{identity}: {nees}");
    }
}

#[test]
fn a_wheel_that_is_too_large_loses_the_wheels_only() {
    let place = folder();
    beats_the_wheels(&sweep(&place, &["robot.radius_bias_right=0.01"]), 1.0);
}

#[test]
fn live_log_and_replay_are_one() {
    let place = folder();
    let (scenario, out) = (filter_scenario("landmarks.toml"), place.at("run"));
    let args = [&scenario, "--ticks", "200", "--set", "sensors.landmarks.identity=hidden"];
    let report = launch("landmarks", &out, &args);
    for name in ["ekf-landmarks", "ekf-slam"] {
        let score = score_of(&report, name);
        let surprise = number(score, "nis/sum") / number(score, "nis/degrees");
        assert!((0.7..1.3).contains(&surprise), "{name}: {surprise}");
    }
    let log = log_of(&report);
    let verdict = about("verify", &log, &["--clients", "--json"]).expect(0).json();
    for name in ["ekf-landmarks", "ekf-slam", "fastslam-1", "fastslam"] {
        let again = named(&verdict["clients"], "participants", name);
        assert_eq!((&again["compared"], &again["equal"]), (&200.into(), &200.into()), "{name}");
    }
}

#[test]
fn without_a_sensor_they_say_what_to_do() {
    let place = folder();
    let log = place.at("run");
    let report = launch("blind", &log, &["apartment", "--ticks", "20", "--without", "score"]);
    for name in ["ekf-landmarks", "ekf-slam", "fastslam"] {
        let refused = execute(name, &["--log", text(&report, "log"), "--name", "dead-reckoning"]);
        refused.expect(1).says("[sensors.landmarks]");
    }
}
