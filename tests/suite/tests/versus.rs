//! Estimators over seeds: whose covariances are right, and which of two is
//! better; from whole runs, through tables, to a sentence.

use std::fs;
use std::path::{Path, PathBuf};

use rusty_tests::{Ended, binary, folder, sim_server, text};
use serde_json::Value;

/// Dead reckoning; the same, sure of itself; and one that believes commands.
fn scenario(folder: &Path, name: &str, ticks: u64) -> PathBuf {
    let (path, probe) = (folder.join(name), binary("probe-client"));
    let text = format!(
        "ticks = {ticks}\nscan_every = 0\nworld = \"open\"\nscript = {{ kind = \"figure-eight\" }}\n\
         [[participant]]\nname = \"wheels\"\ncommand = [\"dead-reckoning\"]\n\
         [[participant]]\nname = \"sure\"\ncommand = [{probe:?}, \"--mode\", \"covariance\"]\n\
         [[participant]]\nname = \"commands\"\ncommand = [{probe:?}, \"--mode\", \"integrates\"]\n\
         [[participant]]\nname = \"score\"\nrole = \"scorer\"\ncommand = [\"score\"]\n\
         [[participant]]\nname = \"logger\"\nrole = \"logger\"\ncommand = [\"logger\"]\n"
    );
    fs::write(&path, text).unwrap();
    path
}

#[track_caller]
fn sweep(scenario: &Path, out: &Path, args: &[&str]) -> Value {
    let mut all = vec!["sweep", scenario.to_str().unwrap(), "--out", out.to_str().unwrap()];
    all.extend(["--json", "--clients"]);
    all.extend(args);
    sim_server(&all).expect(0).json()
}

#[track_caller]
fn compare(tables: &[&Path], args: &[&str], code: i32) -> Ended {
    let mut all = vec!["compare"];
    all.extend(tables.iter().map(|t| t.to_str().unwrap()));
    all.extend(args);
    sim_server(&all).expect(code)
}

fn column(path: &Path, name: &str) -> Vec<String> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let at = reader.headers().unwrap().iter().position(|n| n == name).unwrap();
    reader.records().map(|r| r.unwrap()[at].to_owned()).collect()
}

#[test]
fn a_sweep_says_whose_covariances_are_right_and_a_comparison_who_is_better() {
    let place = folder();
    let [csv, parquet] = ["t.csv", "t.parquet"].map(|n| place.path().join(n));
    let scenario = scenario(place.path(), "three.toml", 120);
    let found = sweep(&scenario, &csv, &["--seeds", "0..6"]);
    sweep(&scenario, &parquet, &["--seeds", "0..6"]);

    let lines = found["report"]["consistency"].as_array().unwrap();
    let names: Vec<&str> = lines.iter().map(|l| text(l, "estimator")).collect();
    assert_eq!(names, ["wheels", "sure", "commands"]);
    assert_eq!((&lines[0]["last"], &lines[0]["runs"]), (&Value::Null, &0.into()));
    let sure = &lines[1];
    assert_eq!((&sure["runs"], &sure["without"]), (&6.into(), &0.into()));
    // An error of millimetres, believed to be a decimetre.
    assert_eq!(sure["last"]["verdict"], "conservative", "{sure}");
    assert_eq!(sure["along"].as_array().unwrap().len(), 60);
    // The scorer's last one, in the mean over the seeds, is that of the log.
    let along = &sure["along"][59];
    assert!(
        (along["anees"].as_f64().unwrap() - sure["last"]["anees"].as_f64().unwrap()).abs() < 1e-9
    );
    let samples = column(&csv, "nees_samples");
    assert_eq!(samples[..3], ["0", "120", "0"]);
    assert!(column(&csv, "compute_observed_p99_s").iter().all(|v| v.parse::<f64>().unwrap() > 0.0));

    let args = ["--a", "wheels", "--b", "commands", "--metric", "ate", "--metric", "final"];
    let json = [&args[..], &["--json"]].concat();
    let mut verdict = compare(&[&csv], &json, 0).json();
    let outcome = &verdict["settings"][0]["outcomes"][0];
    assert_eq!((&outcome["pairs"], &outcome["better"]), (&6.into(), &"a".into()), "{outcome}");
    assert_eq!(outcome["wins"], serde_json::json!([6, 0]));
    // 2 · 2⁻⁶.
    assert!((outcome["sign_p"].as_f64().unwrap() - 0.03125).abs() < 1e-12);
    let mean = |name: &str| {
        let (names, ate) = (column(&csv, "estimator"), column(&csv, "ate_rmse_m"));
        let own = names.iter().zip(&ate).filter(|(n, _)| *n == name).map(|(_, v)| v);
        own.map(|v| v.parse::<f64>().unwrap()).sum::<f64>() / 6.0
    };
    let means = [mean("wheels"), mean("commands")];
    for (found, expected) in outcome["means"].as_array().unwrap().iter().zip(means) {
        assert!((found.as_f64().unwrap() - expected).abs() < 1e-12);
    }
    let said = compare(&[&csv], &args, 0).stdout;
    assert!(said.contains("wheels is better: commands has"), "{said}");
    assert!(said.contains("wins 6 of 6 seeds, p = 0.031"), "{said}");
    assert!(said.contains("no independent tests"), "{said}");

    // The same from the other kind of table, and from one of each.
    let other = compare(&[&parquet], &json, 0).json();
    assert_eq!(verdict["settings"], other["settings"]);
    let across = compare(&[&csv, &parquet], &json, 0).json();
    assert_eq!(verdict["settings"].take(), across["settings"]);
    let same = compare(&[&csv], &["--a", "wheels", "--b", "sure"], 0).stdout;
    assert!(same.contains("equal to the bit in all 6 seeds"), "{same}");
}

#[test]
fn what_cannot_be_compared_is_named_with_its_remedy() {
    let place = folder();
    let table = |name: &str, args: &[&str]| {
        let out = place.path().join(name);
        let mut all = vec!["sweep", "patrol", "--ticks", "50", "--out", out.to_str().unwrap()];
        all.extend(args);
        sim_server(&all).expect(0);
        out
    };
    let a = table("a.csv", &["--seeds", "0..4"]);
    let slip = table("slip.csv", &["--seeds", "0..4", "--set", "robot.slip_std=0.05"]);
    let later = table("later.parquet", &["--seeds", "8..12"]);
    let one = table("one.csv", &["--seeds", "3..9"]);
    let scenario = place.path().join("no.csv");
    fs::write(&scenario, "x,y\n1,2\n").unwrap();
    let cases: [(&[&Path], &[&str], &str); 8] = [
        (&[&a], &[], "say who else with --b NAME, or give a second table"),
        (&[&a, &a], &["--a", "mine"], "has no estimator \"mine\""),
        (&[&a, &slip], &[], "robot.slip_std: 0.02 and 0.05"),
        (&[&a, &later], &[], "share no seed"),
        (&[&a, &one], &[], "one pair has no interval"),
        (&[&a, &a], &["--metric", "nees"], "compare another --metric (asked for: nees)"),
        (&[&a, &a], &["--level", "95"], "give --level 0.95"),
        (&[&scenario], &[], "has no column \"seed\""),
    ];
    for (tables, args, words) in cases {
        let said = compare(tables, args, 2).stderr;
        assert!(said.contains(words), "{words:?} is not in {said}");
    }
    let said = compare(&[&place.path().join("nowhere.csv")], &[], 1).stderr;
    assert!(said.contains("nowhere.csv"), "{said}");
    // A table without what was beside it: rows and ways decide.
    let moved = place.path().join("moved.csv");
    fs::copy(&slip, &moved).unwrap();
    let said = compare(&[&a, &moved], &[], 2).stderr;
    assert!(
        said.contains("did not drive the same run") || said.contains("different runs"),
        "{said}"
    );
    let alone = place.path().join("alone.csv");
    fs::copy(&a, &alone).unwrap();
    let said = compare(&[&a, &alone], &[], 0).stdout;
    assert!(said.contains("only ticks and distances were compared"), "{said}");
}
