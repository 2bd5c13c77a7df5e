//! Comparisons of tables whose answer is known.

use rusty_sim::noise::TickNoise;
use serde_json::json;

use super::contents::Run;
use super::contest::{Better, versus};
use super::*;

/// Where a metric stands among the figures.
fn at(metric: Metric) -> usize {
    Metric::ALL.iter().position(|m| *m == metric).unwrap()
}

fn run(seed: u64, estimator: usize, ate_m: f64) -> Run {
    let mut figures = [f64::NAN; Metric::ALL.len()];
    figures[at(Metric::Ate)] = ate_m;
    let distance_m = 14.0 + seed as f64;
    Run { seed, setting: 0, estimator, ticks: 300, distance_m, figures }
}

/// A table with these estimators and no swept field.
fn contents(path: &str, names: &[&str], runs: Vec<Run>) -> Contents {
    Contents {
        path: path.to_owned(),
        estimators: names.iter().map(|n| (*n).to_owned()).collect(),
        settings: vec![String::new()],
        runs,
        configs: Some(vec![(String::new(), json!({ "ticks": 300, "dt_s": 0.1 }))]),
    }
}

/// Two estimators that meet the same noise; the second is better by `gain_m`.
fn two(seeds: u64, gain_m: f64) -> Contents {
    let mut runs = Vec::new();
    for seed in 0..seeds {
        let [common, own] = TickNoise::slip(seed).normals(0);
        let a_m = 0.5 + 0.1 * common;
        runs.push(run(seed, 0, a_m));
        runs.push(run(seed, 1, a_m - gain_m + 0.005 * own));
    }
    contents("t.csv", &["old", "new"], runs)
}

fn ate(table: &Contents) -> contest::Outcome {
    let both = sides(table, None, [None, None]).unwrap();
    let mut found = versus(both, &Metric::USUAL, false, 0.95).unwrap();
    assert_eq!(found.settings[0].outcomes.len(), 1, "only what has figures: {found:?}");
    found.settings[0].outcomes.swap_remove(0)
}

#[test]
fn who_is_better_and_by_how_much() {
    let found = ate(&two(100, 0.02));
    assert_eq!((found.paired.pairs, found.better), (100, Some(Better::B)));
    assert!((found.paired.difference + 0.02).abs() < 0.002, "{found:?}");
    let [low, high] = found.interval;
    assert!(low < -0.02 && -0.02 < high && high - low < 0.003, "{found:?}");
    assert!(found.wins[1] > 95 && found.sign_p < 1e-20, "{found:?}");
    assert!((found.effect_percent + 4.0).abs() < 0.5, "{}", found.effect_percent);
    // Spreads of 0.1 against 0.005: some hundreds of times the runs.
    assert!(found.paired.variance_reduction > 100.0 && found.paired.correlation > 0.99);
    let text = &found.verdict;
    assert!(text.starts_with("ATE rmse: new is better: it has 0.0"), "{text}");
    assert!(text.contains(" m less (-3.9 %)") && text.contains("95 % in [-0.0"), "{text}");
    // The other way round, old has less.
    let turned = ate(&two(100, -0.02));
    assert_eq!((turned.better, turned.wins[0] > 95), (Some(Better::A), true));
    assert!(turned.verdict.contains("old is better: new has 0.0"), "{}", turned.verdict);
}

#[test]
fn no_difference_is_said_so() {
    let found = ate(&two(30, 0.0));
    assert_eq!(found.better, None, "{found:?}");
    assert!(found.verdict.contains("no difference shown"), "{}", found.verdict);
    let mut same = two(10, 0.0);
    for i in 0..10 {
        same.runs[2 * i + 1].figures = same.runs[2 * i].figures;
    }
    let same = ate(&same);
    assert_eq!((same.ties, same.sign_p, same.better), (10, 1.0, None));
    assert!(same.verdict.contains("equal to the bit in all 10 seeds"), "{}", same.verdict);
}

#[test]
fn the_mean_and_the_signs_may_disagree() {
    // Better in nine of ten seeds by little, worse in the others by far more.
    let mut runs = Vec::new();
    for seed in 0..100 {
        let gain_m = if seed % 10 == 0 { -0.2 } else { 0.01 };
        runs.extend([run(seed, 0, 0.5), run(seed, 1, 0.5 - gain_m)]);
    }
    let found = ate(&contents("t.csv", &["old", "new"], runs));
    assert_eq!((found.better, found.wins), (None, [10, 90]));
    assert!(found.sign_p < 1e-10 && found.verdict.contains("a few seeds weigh against it"));
}

#[test]
fn too_few_seeds_are_no_reason_to_doubt_the_mean() {
    let sentence = |wins: [u64; 2]| {
        let run_of = |seed: u64, b_wins: bool| {
            let gain_m = if b_wins { 0.02 + 1e-4 * seed as f64 } else { -1e-3 };
            [run(seed, 0, 0.5), run(seed, 1, 0.5 - gain_m)]
        };
        let runs = (0..wins[0] + wins[1]).flat_map(|seed| run_of(seed, seed >= wins[0]));
        ate(&contents("t.csv", &["old", "new"], runs.collect())).verdict
    };
    assert!(sentence([0, 5]).ends_with("too few seeds for the signs to tell"));
    assert!(sentence([1, 6]).ends_with("the signs alone do not show it"), "{}", sentence([1, 6]));
    assert!(sentence([0, 6]).ends_with("p = 0.031"), "{}", sentence([0, 6]));
    // Always better, by amounts that have nothing in common.
    let gains_m = [1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 0.1];
    let pair = |(seed, gain_m)| [run(seed, 0, 0.5), run(seed, 1, 0.5 - gain_m)];
    let runs = (0..6).zip(gains_m).flat_map(pair).collect();
    let found = ate(&contents("t.csv", &["old", "new"], runs));
    assert_eq!((found.better, found.wins), (None, [0, 6]));
    assert!(found.verdict.ends_with("too unlike for the mean"), "{}", found.verdict);
}

#[test]
fn who_never_converges_loses_to_who_does() {
    // A in all seeds, after 2 s; B in few, after 1 s.
    let timed = |b: fn(u64) -> bool| {
        let mut runs = Vec::new();
        for seed in 0..20 {
            let mut pair = [run(seed, 0, 0.5), run(seed, 1, 0.5)];
            pair[0].figures[at(Metric::Converged)] = 2.0 + 1e-3 * seed as f64;
            if b(seed) {
                pair[1].figures[at(Metric::Converged)] = 1.0;
            }
            runs.extend(pair);
        }
        let table = contents("t.csv", &["sound", "brittle"], runs);
        let both = sides(&table, None, [None, None]).unwrap();
        versus(both, &[Metric::Converged], true, 0.95).unwrap().settings[0].outcomes[0].clone()
    };
    let few = timed(|seed| seed < 4);
    assert_eq!((few.better, few.wins, few.one_sided), (Some(Better::A), [16, 4], [16, 0]));
    assert!(few.verdict.starts_with("convergence time: sound is better: sound wins 16 of 20"));
    let never = timed(|_| false);
    assert_eq!((never.better, never.paired.pairs), (Some(Better::A), 0), "{never:?}");
    let half = timed(|seed| seed < 10);
    assert_eq!((half.better, half.wins), (None, [10, 10]));
    assert!(half.verdict.contains("no difference shown at 95 %"), "{}", half.verdict);
}

#[test]
fn settings_of_one_configuration_are_not_mixed_up() {
    // Two settings that differ in what is no part of a configuration.
    let settings = |words: [&str; 2]| {
        let mut table = two(10, 0.02);
        let second = table.runs.clone().into_iter().map(|r| Run { setting: 1, ..r });
        table.runs.extend(second.collect::<Vec<_>>());
        table.settings = words.map(str::to_owned).to_vec();
        let config = json!({ "ticks": 300 });
        table.configs = Some(words.map(|w| (w.to_owned(), config.clone())).to_vec());
        for run in table.runs.iter_mut().filter(|r| r.setting == 1 && r.estimator == 1) {
            run.figures[at(Metric::Ate)] += 1.0;
        }
        table
    };
    let table = settings(["late=0", "late=1"]);
    let both = sides(&table, None, [None, None]).unwrap();
    let found = versus(both, &[Metric::Ate], true, 0.95).unwrap();
    let better: Vec<_> = found.settings.iter().map(|s| s.outcomes[0].better).collect();
    assert_eq!(better, [Some(Better::B), Some(Better::A)]);
    // Of another table with one such setting it is not known which is meant.
    let one = two(10, 0.02);
    let mut one = Contents { path: "u.csv".to_owned(), ..one };
    one.configs = Some(vec![(String::new(), json!({ "ticks": 300 }))]);
    let both = sides(&table, Some(&one), [Some("old"), Some("new")]).unwrap();
    assert!(matches!(versus(both, &[Metric::Ate], true, 0.95), Err(VersusError::Settings { .. })));
}

#[test]
fn figures_that_are_missing_are_counted_and_named() {
    let mut table = two(20, 0.02);
    table.runs[7].figures[at(Metric::Ate)] = f64::NAN;
    table.runs.remove(0);
    let both = sides(&table, None, [Some("old"), None]).unwrap();
    let found = versus(both, &Metric::USUAL, false, 0.95).unwrap();
    let contest = &found.settings[0];
    assert_eq!((contest.seeds, &contest.alone), (19, &[vec![], vec![0]]));
    assert_eq!(
        (contest.outcomes[0].paired.pairs, &contest.outcomes[0].paired.missing),
        (18, &[vec![], vec![3]])
    );
    let text = found.to_string();
    assert!(text.contains("A lacks seed 0"), "{text}");
    assert!(text.contains("new has no ATE rmse in 1 runs: seed 3"), "{text}");
    // Asked for by name, a metric without a figure is not left out.
    let asked = versus(both, &[Metric::Ate, Metric::Nees], true, 0.95).unwrap();
    assert_eq!(asked.settings[0].outcomes[1].paired.pairs, 0);
    assert!(asked.remarks.iter().any(|r| r.contains("no independent tests")), "{asked:?}");
}

#[test]
fn who_did_not_drive_the_same_runs_is_not_compared() {
    let (a, b) = (two(10, 0.0), two(10, 0.02));
    let compared = |a: &Contents, b: &Contents| {
        let both = sides(a, Some(b), [Some("old"), Some("new")])?;
        versus(both, &[Metric::Ate], true, 0.95)
    };
    assert_eq!(compared(&a, &b).unwrap().settings[0].seeds, 10);
    let mut other = b.clone();
    other.runs[7].distance_m = other.runs[7].distance_m.next_up();
    let said = compared(&a, &other).unwrap_err().to_string();
    assert!(said.contains("seed 3: the robot drove 17 m") && said.contains("17.000000000000004"));
    // One that ended early is left out.
    let mut short = b.clone();
    (short.runs[7].ticks, short.runs[7].distance_m) = (120, 5.0);
    let found = compared(&a, &short).unwrap();
    assert_eq!((found.settings[0].seeds, &found.settings[0].cut_short), (9, &vec![3]));
    let mut later = b.clone();
    later.runs.iter_mut().for_each(|r| r.seed += 100);
    assert!(matches!(compared(&a, &later), Err(VersusError::NoPair { .. })));
    let mut one = b.clone();
    one.runs.truncate(2);
    let said = compared(&a, &one).unwrap_err().to_string();
    assert!(said.contains("one pair has no interval"), "{said}");
    let mut set = b.clone();
    set.configs = Some(vec![(String::new(), json!({ "ticks": 300, "dt_s": 0.05 }))]);
    let said = compared(&a, &set).unwrap_err().to_string();
    assert!(said.contains("dt_s: 0.1 and 0.05"), "{said}");
}

#[test]
fn settings_are_matched_by_what_they_are() {
    let config = |slip: f64| json!({ "robot": { "slip_std": slip } });
    let mut a = two(4, 0.1);
    a.settings = vec!["robot.slip_std=0.01".to_owned(), "robot.slip_std=0.02".to_owned()];
    a.configs = Some(a.settings.iter().cloned().zip([config(0.01), config(0.02)]).collect());
    let again: Vec<Run> = a.runs.iter().map(|r| Run { setting: 1, ..r.clone() }).collect();
    a.runs.extend(again);
    // Not swept, but written into its scenario.
    let mut b = two(4, 0.1);
    b.configs = Some(vec![(String::new(), config(0.02))]);
    let both = sides(&a, Some(&b), [Some("old"), Some("new")]).unwrap();
    let found = versus(both, &[Metric::Ate], true, 0.95).unwrap();
    assert_eq!(found.settings.len(), 1);
    assert_eq!(found.settings[0].setting, "robot.slip_std=0.02");
    assert!(found.remarks[0].contains("1 settings that are not in both"), "{:?}", found.remarks);
    // In one table, each setting by itself.
    let found = versus(sides(&a, None, [None, None]).unwrap(), &[Metric::Ate], true, 0.95).unwrap();
    let seeds: Vec<usize> = found.settings.iter().map(|c| c.seeds).collect();
    assert_eq!(seeds, [4, 4]);
}

#[test]
fn names_are_taken_where_there_is_no_choice() {
    let (two, one) = (two(2, 0.0), contents("u.csv", &["new"], Vec::new()));
    let names = |other: Option<&Contents>, ab: [Option<&str>; 2]| {
        sides(&two, other, ab)
            .map(|both| both.map(|s| s.name().to_owned()))
            .map_err(|e| e.to_string())
    };
    let expected = |a: &str, b: &str| Ok([a.to_owned(), b.to_owned()]);
    assert_eq!(names(None, [None, None]), expected("old", "new"));
    assert_eq!(names(None, [Some("new"), None]), expected("new", "old"));
    assert_eq!(names(None, [None, Some("old")]), expected("new", "old"));
    assert_eq!(names(Some(&two), [Some("old"), None]), expected("old", "old"));
    assert_eq!(names(Some(&one), [Some("old"), None]), expected("old", "new"));
    let said = names(None, [Some("old"), Some("old")]).unwrap_err();
    assert!(said.contains("A and B are both old") && said.contains("--b NAME"), "{said}");
    let said = sides(&one, None, [None, None]).unwrap_err().to_string();
    assert!(said.contains("both new") && said.contains("--add NAME=COMMAND"), "{said}");
    let said = names(None, [Some("odl"), None]).unwrap_err();
    assert!(said.contains("has no estimator \"odl\"; its estimators are old, new"), "{said}");
    let three = contents("v.csv", &["x", "y", "z"], Vec::new());
    let said = sides(&three, None, [None, None]).unwrap_err().to_string();
    assert!(said.contains("has 3 estimators") && said.contains("--a NAME"), "{said}");
}

#[test]
fn twice_too_large_is_as_far_off_as_twice_too_small() {
    assert!((Metric::Nees.of(6.0) - Metric::Nees.of(1.5)).abs() < 1e-15);
    assert_eq!(Metric::Nees.of(3.0), 0.0);
    assert!(Metric::Nees.of(f64::NAN).is_nan());
}

#[test]
fn a_comparison_can_be_drawn_with_every_seed() {
    let table = two(40, 0.02);
    let both = sides(&table, None, [None, None]).unwrap();
    let found = versus(both, &Metric::USUAL, false, 0.95).unwrap();
    let page = drawing::drawing(&found);
    for words in ["A: old", "B: new", "ATE rmse, B − A (m)", "share of the runs", "seeds, sorted"]
    {
        assert!(page.contains(words), "{words}");
    }
    assert!(!page.contains("NaN") && rusty_plot::png(&page).unwrap().len() > 3_000);
    // A bar for every seed: B is better by more than its own noise in all of them.
    let blue = page.matches("<polygon").count();
    assert!(blue >= 40, "{blue} bars");
}
