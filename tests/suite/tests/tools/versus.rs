//! Estimators over seeds: whose covariances are right, and which of two is
//! better; from whole runs, through tables, to a sentence.

use rusty_tests::*;

/// Dead reckoning; the same, sure of itself; and one that believes commands.
fn scenario(folder: &Path, name: &str, ticks: u64) -> PathBuf {
    let probe = binary("probe-client");
    let roster = [
        estimator("wheels", &["dead-reckoning"], ""),
        estimator("sure", &[arg(&probe), "--mode", "covariance"], ""),
        estimator("commands", &[arg(&probe), "--mode", "integrates"], ""),
    ];
    let run = format!(
        "ticks = {ticks}\nscan_every = 0\nworld = \"open\"\nscript = {{ kind = \"figure-eight\" }}\n"
    );
    PathBuf::from(write(folder, name, [&run, &roster.concat(), RECORDERS].concat()))
}

#[track_caller]
fn sweep(scenario: &Path, out: &Path, args: &[&str]) -> Value {
    let all = ["sweep", arg(scenario), "--out", arg(out), "--json", "--clients"];
    sim_server(&[&all, args].concat()).expect(0).json()
}

#[track_caller]
fn compare(tables: &[&Path], args: &[&str], code: i32) -> Ended {
    let tables: Vec<&str> = tables.iter().map(|table| arg(table)).collect();
    sim_server(&[&["compare"], &tables[..], args].concat()).expect(code)
}

#[test]
fn a_sweep_says_whose_covariances_are_right_and_a_comparison_who_is_better() {
    let place = folder();
    let [csv, parquet] = ["t.csv", "p.parquet"].map(|n| place.at(n));
    let scenario = scenario(place.path(), "three.toml", 120);
    let found = sweep(&scenario, &csv, &["--seeds", "0..6"]);
    sweep(&scenario, &parquet, &["--seeds", "0..6"]);

    let lines = list(&found["report"], "consistency");
    let names: Vec<&str> = lines.iter().map(|l| text(l, "estimator")).collect();
    assert_eq!(names, ["wheels", "sure", "commands"]);
    assert_eq!((&lines[0]["last"], &lines[0]["runs"]), (&Value::Null, &0.into()));
    let sure = &lines[1];
    assert_eq!((&sure["runs"], &sure["without"]), (&6.into(), &0.into()));
    // An error of millimetres, believed to be a decimetre.
    assert_eq!(sure["last"]["verdict"], "conservative", "{sure}");
    assert_eq!(list(sure, "along").len(), 60);
    // The scorer's last one, in the mean over the seeds, is that of the log.
    let along = &sure["along"][59];
    assert!((number(along, "anees") - number(sure, "last/anees")).abs() < 1e-9);
    let table = Table::read(&csv);
    let samples = table.column("nees_samples");
    assert_eq!(samples[..3], ["0", "120", "0"]);
    assert!(table.numbers("compute_observed_p99_s").iter().all(|v| *v > 0.0));

    let args = ["--a", "wheels", "--b", "commands", "--metric", "ate", "--metric", "final"];
    let json = [&args[..], &["--json"]].concat();
    let mut verdict = compare(&[&csv], &json, 0).json();
    let outcome = &verdict["settings"][0]["outcomes"][0];
    assert_eq!((&outcome["pairs"], &outcome["better"]), (&6.into(), &"a".into()), "{outcome}");
    assert_eq!(outcome["wins"], json!([6, 0]));
    // 2 · 2⁻⁶.
    assert!((number(outcome, "sign_p") - 0.03125).abs() < 1e-12);
    let mean = |name: &str| {
        let (names, ate) = (table.column("estimator"), table.numbers("ate_rmse_m"));
        let own = names.iter().zip(&ate).filter(|(n, _)| **n == name).map(|(_, v)| v);
        own.sum::<f64>() / 6.0
    };
    let means = [mean("wheels"), mean("commands")];
    for (found, expected) in list(outcome, "means").iter().zip(means) {
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
        let out = place.at(name);
        let mut all = vec!["sweep", "patrol", "--ticks", "50", "--out", arg(&out)];
        all.extend(args);
        sim_server(&all).expect(0);
        out
    };
    let a = table("a.csv", &["--seeds", "0..4"]);
    let slip = table("slip.csv", &["--seeds", "0..4", "--set", "robot.slip_std=0.05"]);
    let later = table("later.parquet", &["--seeds", "8..12"]);
    let one = table("one.csv", &["--seeds", "3..9"]);
    let scenario = place.at("no.csv");
    fs::write(&scenario, "x,y\n1,2\n").unwrap();
    let cut = table("cut.csv", &["--seeds", "0..5"]);
    let rows = fs::read_to_string(&cut).unwrap();
    fs::write(&cut, rows.lines().take(3).map(|line| format!("{line}\n")).collect::<String>())
        .unwrap();
    let double = place.at("double.csv");
    fs::write(&double, format!("{rows}{}\n", rows.lines().nth(2).unwrap())).unwrap();
    let cases: [(&[&Path], &[&str], &str); 10] = [
        (&[&a, &double], &[], "has seed 1 of an estimator twice"),
        (&[&a, &cut], &[], "2 of the 5 runs"),
        (&[&a], &[], "sweep with `--clients --add NAME=COMMAND`, or give a second table"),
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
    let said = compare(&[&place.at("nowhere.csv")], &[], 1).stderr;
    assert!(said.contains("nowhere.csv"), "{said}");
    // A table without what was next to it: rows and ways decide.
    let moved = place.at("moved.csv");
    fs::copy(&slip, &moved).unwrap();
    let said = compare(&[&a, &moved], &[], 2).stderr;
    assert!(
        said.contains("did not drive the same run") || said.contains("different runs"),
        "{said}"
    );
    let alone = place.at("alone.csv");
    fs::copy(&a, &alone).unwrap();
    let said = compare(&[&a, &alone], &[], 0).stdout;
    assert!(said.contains("only ticks and distances were compared"), "{said}");
}
