//! `grid-localisation` as a process: lost at the start, live, from a log and in a replay.

use rusty_tests::*;

#[test]
fn it_finds_itself_within_a_cell_and_answers_the_same_again() {
    for seed in ["0", "1", "2"] {
        let place = folder();
        let grid = "--add=grid=grid-localisation --global";
        let scenario = filter_scenario("global.toml");
        let args = [&scenario, "--seed", seed, "--ticks", "300", "--without", "mcl", grid];
        let report = launch("grid", place.path(), &args);
        let score = score_of(&report, "grid");
        let found = &score["convergence"];
        assert!(number(found, "after_s") < 3.0, "seed {seed}: {found}");
        assert!(number(found, "position_rmse_m") < 0.1, "seed {seed}: {found}");
        assert!(number(score, "final_position_error_m") < 0.15, "seed {seed}: {score}");
        assert_eq!(score["nees"]["unusable"], 0, "seed {seed}: {score}");
        if seed == "0" {
            let log = log_of(&report);
            about("verify", &log, &["--clients"]).expect(0).prints("300 answers of grid");
        }
    }
}

#[test]
fn with_too_many_cells_it_says_what_to_do() {
    let place = folder();
    let grid = "--add=grid=grid-localisation --global";
    let args = [&filter_scenario("global.toml"), "--ticks", "10", "--without", "mcl", grid];
    let report = launch("blind", &place.at("run"), &args);
    let refused = execute(
        "grid-localisation",
        &["--log", text(&report, "log"), "--name", "grid", "--cell-m", "0.01", "--turn-deg", "1"],
    );
    refused.expect(1).says("a larger --cell-m than 0.01");
}
