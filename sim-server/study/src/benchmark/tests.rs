//! Tests of the benchmark: plans, scores, verdicts, changed results.

use std::collections::BTreeMap;

use rusty_contract::scenario::Access;
use rusty_contract::{Role, Sandbox};

use super::block::blocks;
use super::recorded_log::RecordedLog;
use super::selection::Wanted;
use super::standings::{Side, standings};
use super::verify::verify;
use super::*;
use crate::benchmark::run::BenchmarkRun;
use crate::versus::Metric;

fn suite() -> Suite {
    Suite::built_in().unwrap()
}

fn entries(suite: &Suite) -> Vec<Entry> {
    let mut all =
        Entry::added(suite, [&["mine=mine".to_owned()], &["racer=racer".to_owned()]], &[]).unwrap();
    all.extend(Entry::baselines(suite));
    all
}

fn selection(suite: &Suite, only: &str, seeds: u64) -> Selection {
    let wanted = Wanted {
        only: vec![only.to_owned()],
        tracks: vec![Track::Localisation],
        seeds: Some(seeds),
        key: None,
        recordings: Vec::new(),
    };
    Selection::of(suite, wanted).unwrap()
}

#[test]
fn every_scenario_of_the_suite_can_be_planned() {
    let suite = suite();
    assert_eq!(suite.scenarios.len(), 13);
    let all = Selection::of(&suite, Wanted::default()).unwrap();
    assert!(all.whole);
    let entries = entries(&suite);
    let blocks = blocks(&suite, &all, &entries);
    for block in &blocks {
        let plans = block.plans(&all, Sandbox::Required).unwrap();
        let [plan] = &plans[..] else { panic!("{}", plans.len()) };
        assert_eq!(plan.count(), suite.seeds);
        let own = plan.rosters[0].iter().find(|p| p.name == block.entry.name).unwrap();
        assert_eq!((own.map, own.initial_pose), (block.map, block.scenario.start));
        let drives = !block.scenario.driving.is_empty();
        assert_eq!((block.entry.is_driver, own.role == Role::Driver), (drives, drives));
        let goals = own.command.iter().filter(|word| *word == "--waypoint").count();
        assert_eq!(goals, block.scenario.goals.len());
        let drivers = plan.rosters[0].iter().filter(|p| p.role == Role::Driver).count();
        assert_eq!(drivers, usize::from(drives || !block.scenario.driver.is_empty()));
        assert_eq!(own.sandbox, Sandbox::Required);
    }
    // An entry that is added comes first, with and without map.
    assert!(blocks.iter().take(21).all(|block| !block.entry.is_baseline));
    let of_global: Vec<&str> = blocks
        .iter()
        .filter(|block| block.scenario.name == "global")
        .map(|block| block.entry.name.as_str())
        .collect();
    assert_eq!(of_global, ["mine", "mcl"]);
    for scenario in &suite.scenarios {
        // The first metric of drivers is a time, and their runs are scored in one track.
        let is_driven = !scenario.driving.is_empty();
        assert_eq!(scenario.metrics(Track::Localisation).len(), if is_driven { 0 } else { 2 });
        assert!(!is_driven || scenario.driving[0] == Metric::Goals && !scenario.goals.is_empty());
    }
}

#[test]
fn a_command_with_the_name_of_the_run_differs_from_seed_to_seed() {
    let suite = suite();
    let added = ["mine=trajectory mine/{run}.tum".to_owned()];
    let entries = Entry::added(&suite, [&added, &[]], &[]).unwrap();
    let mut some = selection(&suite, "few-beams", 3);
    some.key = Some("secret".to_owned());
    let blocks = blocks(&suite, &some, &entries);
    let plans = blocks[0].plans(&some, Sandbox::Required).unwrap();
    let words = |plan: &crate::sweep::Plan| (plan.place(0).1, plan.rosters[0][0].command.clone());
    let seeds = some.seeds_of(blocks[0].scenario).unwrap();
    let expected = |(number, seed): (u64, &u64)| {
        let file = format!("mine/few-beams-given-{number}.tum");
        (*seed, vec!["trajectory".to_owned(), file])
    };
    let expected: Vec<_> = (0..).zip(&seeds).map(expected).collect();
    assert_eq!(plans.iter().map(words).collect::<Vec<_>>(), expected);
}

#[test]
fn tracks_are_those_of_the_entries_that_are_added() {
    let suite = suite();
    let with = |add: &[&str], drivers: &[&str], tracks: &[Track]| {
        let texts = |all: &[&str]| all.iter().map(|t| (*t).to_owned()).collect::<Vec<_>>();
        let added = Entry::added(&suite, [&texts(add), &texts(drivers)], &[]).unwrap();
        let wanted = Wanted { tracks: tracks.to_vec(), ..Wanted::default() };
        Selection::with(&suite, wanted, &added)
    };
    let tracks = |add: &[&str], drivers: &[&str]| with(add, drivers, &[]).unwrap().tracks;
    assert_eq!(tracks(&["a=a"], &[]), Track::ALL[..3]);
    assert_eq!(tracks(&[], &["b=b"]), [Track::Driving]);
    assert_eq!(tracks(&["a=a"], &["b=b"]), Track::ALL);
    assert_eq!(tracks(&[], &[]), Track::ALL);
    let refused = with(&["a=a"], &["b=b"], &[Track::Driving]).unwrap_err().to_string();
    assert!(refused.contains("--add") && refused.contains("another track"), "{refused}");
    let refused = with(&[], &["b=b"], &[Track::Slam]).unwrap_err().to_string();
    assert!(refused.contains("--driver") && refused.contains("driving"), "{refused}");
}

#[test]
fn a_key_gives_other_seeds_that_cannot_be_tried() {
    let suite = suite();
    let of = |key: Option<&str>| {
        let key = key.map(str::to_owned);
        let wanted = Wanted { key, seeds: Some(3), ..Wanted::default() };
        Selection::of(&suite, wanted).unwrap().seeds().unwrap()
    };
    assert_eq!((of(None).at(0), of(None).count()), (0, 3));
    assert_eq!(of(Some("a")), of(Some("a")));
    assert_ne!(of(Some("a")), of(Some("b")));
    assert!(of(Some("a")).at(0) > 1 << 40);
}

/// Runs of a scenario in which `mine` has half the error of the baselines.
fn runs(seeds: u64, failed: &[u64]) -> Vec<BenchmarkRun> {
    let run = |entry: &str, seed: u64, error: f64, failure: Option<String>| BenchmarkRun {
        scenario: "few-beams".to_owned(),
        map: Access::Given,
        entry: entry.to_owned(),
        seed,
        digest: format!("{seed:032x}"),
        ticks: 1500,
        answered_ticks: 1500,
        distance_m: Some(5.0),
        figures: BTreeMap::from([
            (Metric::Ate, failure.is_none().then_some(error)),
            (Metric::Heading, Some(0.01)),
        ]),
        compute_p50_s: None,
        compute_p99_s: Some(0.001),
        failure,
    };
    let all = (0..seeds).flat_map(|seed| {
        let error = 0.1 + 0.01 * seed as f64;
        let failure = failed.contains(&seed).then(|| "dead".to_owned());
        let baselines = ["mcl", "ekf"].map(|name| run(name, seed, error, None));
        [run("mine", seed, error / 2.0, failure)].into_iter().chain(baselines)
    });
    all.collect()
}

#[test]
fn an_entry_is_compared_seed_by_seed_and_failures_count_as_losses() {
    let suite = suite();
    let selection = selection(&suite, "few-beams", 6);
    let verdict = |runs: &[BenchmarkRun]| {
        let (scores, verdicts) = standings(&suite, &selection, &entries(&suite), runs);
        let is_it = |entry: &str, metric| entry == "mine" && metric == Metric::Ate;
        let score = scores.into_iter().find(|s| is_it(&s.entry, s.metric)).unwrap();
        let mut verdicts = verdicts.into_iter().filter(|v| is_it(&v.entry, v.metric));
        (score, verdicts.find(|v| v.baseline == "mcl").unwrap())
    };
    let (score, better) = verdict(&runs(6, &[]));
    assert_eq!((score.runs, score.failed, better.pairs), (6, 0, 6));
    assert!((score.mean.unwrap() - 0.0625).abs() < 1e-12, "{score:?}");
    let score_of_all = score.mean;
    assert_eq!((better.better, better.wins), (Some(Side::Entry), [0, 6]));
    assert!(better.decides && better.is_reference);
    let (score, lost) = verdict(&runs(6, &[0, 1, 2, 3, 4, 5]));
    assert_eq!((score.runs, score.failed, score.mean), (0, 6, None));
    assert_eq!((lost.better, lost.wins), (Some(Side::Baseline), [6, 0]));
    // Nine tenths of the answers of the baseline with the most are enough, less are not.
    let answered = |mine: u64, mcl: u64| {
        let mut runs = runs(6, &[]);
        for run in &mut runs {
            match run.entry.as_str() {
                "mine" => run.answered_ticks = mine,
                "mcl" => run.answered_ticks = mcl,
                _ => {}
            }
        }
        runs.reverse();
        verdict(&runs)
    };
    let (enough, same) = answered(1350, 1500);
    assert_eq!((enough.mean, same.better), (score_of_all, Some(Side::Entry)));
    let (score, lazy) = answered(1349, 0);
    assert_eq!((score.runs, score.failed, score.without, score.mean), (0, 0, 6, None));
    assert_eq!((lazy.better, lazy.pairs), (None, 0), "mcl has no figure either");
    let (_, lazy) = answered(1, 1500);
    assert_eq!((lazy.better, lazy.wins), (Some(Side::Baseline), [6, 0]));
}

fn result(runs: Vec<BenchmarkRun>) -> BenchmarkResult {
    let suite = suite();
    let rest = (true, "test".to_owned(), serde_json::Value::Null);
    let selection = selection(&suite, "few-beams", 6);
    BenchmarkResult::of(&suite, selection, entries(&suite), runs, rest).unwrap()
}

#[test]
fn what_was_changed_in_a_result_is_found() {
    let (suite, honest) = (suite(), result(runs(6, &[])));
    let baselines = Entry::baselines(&suite);
    let made: Vec<BenchmarkRun> =
        honest.runs.iter().filter(|run| run.entry != "mine").cloned().collect();
    let differences = |result: &BenchmarkResult| {
        verify(result, &suite, &baselines, made.clone()).unwrap().differences
    };
    let text = serde_json::to_string(&honest).unwrap();
    let again: BenchmarkResult = serde_json::from_str(&text).unwrap();
    assert_eq!(again, honest);
    assert_eq!(differences(&again), Vec::<String>::new());
    let mut score = honest.clone();
    score.scores[0].mean = Some(0.001);
    assert!(
        differences(&score)[0].starts_with("scores.few-beams/localisation/mine/ate.mean: 0.001")
    );
    let mut digest = honest.clone();
    digest.runs[1].digest = "f".repeat(32);
    assert!(differences(&digest)[0].starts_with("runs.few-beams/given/mcl/0.digest"));
    // Without its program, a run of `mine` is not made again; its scores still follow from it.
    let mut figure = honest.clone();
    figure.runs[0].figures.insert(Metric::Ate, Some(0.0));
    assert!(!differences(&figure).is_empty());
    for name in ["mcl", "mine"] {
        let mut missing = honest.clone();
        missing.runs.retain(|run| run.entry != name || run.seed != 2);
        let place = format!("runs.few-beams/given/{name}/2: ");
        assert!(differences(&missing).iter().any(|d| d.starts_with(&place)), "{name}");
    }
    let mut whole = honest.clone();
    whole.selection.whole = true;
    assert_eq!(differences(&whole), ["selection.whole: true and false"]);
    let mut compute = honest;
    compute.runs[1].compute_p99_s = Some(7.0);
    compute.machine = serde_json::json!({ "cpu": "another" });
    assert_eq!(differences(&compute), Vec::<String>::new());
}

#[test]
fn the_leaderboard_has_the_best_first_and_refuses_other_runs() {
    let suite = suite();
    let mut results = vec![("a.json".to_owned(), result(runs(6, &[])))];
    let board = leaderboard(&suite, &results).unwrap();
    let localisation: Vec<&str> =
        board.iter().filter(|s| s.track == Track::Localisation).map(|s| s.entry.as_str()).collect();
    assert_eq!(localisation[0], "mine");
    let (mine, mcl) = (&board[0], board.iter().find(|s| s.entry == "mcl").unwrap());
    assert!(mcl.is_reference && !mine.is_reference);
    assert_eq!((mine.scenarios, mcl.relative_error), ([1, 0, 0], Some(1.0)));
    assert!((mine.relative_error.unwrap() - 0.5).abs() < 1e-9);
    let page = page::page(&suite, &results, &board);
    assert!(page.contains("<svg") && page.contains("few-beams"));
    let line = |text: &str| page.lines().filter(|line| line.starts_with(text)).count();
    assert_eq!([line("localisation  mcl"), line("localisation  few-beams")], [1, 6]);
    let mut other = results[0].1.clone();
    other.selection.key = Some("b".to_owned());
    results.push(("b.json".to_owned(), other));
    assert!(matches!(leaderboard(&suite, &results), Err(BenchmarkError::OtherSuite { .. })));
}

#[test]
fn recordings_are_one_more_scenario_and_keep_the_digest_of_the_suite() {
    let suite = Suite::built_in().unwrap();
    let log = |name: &str, digest: &str| RecordedLog { name: name.into(), digest: digest.into() };
    let logs = vec![log("intel", "aa"), log("csail", "bb")];
    let with = suite.clone().with(&logs);
    assert_eq!(with.digest().unwrap(), suite.digest().unwrap());
    assert_eq!(suite.clone().with(&[]).scenarios.len(), suite.scenarios.len());
    let select = |only: &[&str]| {
        let only = only.iter().map(|name| (*name).to_owned()).collect();
        let recordings = logs.clone();
        Selection::of(&with, Wanted { only, recordings, seeds: Some(5), ..Wanted::default() })
    };
    let own = select(&["recordings"]).unwrap();
    let blocks: Vec<&str> = own.blocks(&with).map(|(_, track)| track.word()).collect();
    assert_eq!((blocks, own.recordings.len()), (vec!["odometry", "slam"], 2));
    let scenario = with.scenarios.last().unwrap();
    assert_eq!(own.seeds_of(scenario).unwrap(), [0, 1]);
    assert_eq!(own.seeds_of(&with.scenarios[0]).unwrap(), [0, 1, 2, 3, 4]);
    // Without their scenario a result has none.
    assert!(select(&["tour"]).unwrap().recordings.is_empty());
}
