//! `bayes-hallway` as a process: not told where it starts, it knows in the end,
//! and says the same again from the log.

use rusty_tests::*;

#[test]
fn it_finds_itself_by_the_doors_and_says_the_same_again() {
    let place = folder();
    let report = launch("hallway", place.path(), &[&filter_scenario("hallway.toml")]);
    let score = &list(&report, "scores")[0];
    assert!(number(score, "final_position_error_m") < 0.25, "{score}");
    assert!(number(score, "final_heading_error_deg") < 3.0, "{score}");
    assert_eq!(score["nees"]["unusable"], 0);

    let log = log_of(&report);
    let verdict = about("verify", &log, &["--clients", "--json"]).expect(0).json();
    let again = &verdict["clients"]["participants"][0];
    assert_eq!((&again["compared"], &again["equal"]), (&1000.into(), &1000.into()));
    // And as a client of a replay.
    let again = replay(&log, &place.at("again"), &[]).expect(0).json();
    assert_eq!(again["digest"], report["digest"]);
}
