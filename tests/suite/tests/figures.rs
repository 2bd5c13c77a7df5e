//! Figures through the commands: those of the chapter, and the same name, digits and
//! alignment wherever a figure is shown.

use std::fs;
use std::path::Path;

use rusty_tests::{folder, fresh_run, launch, sim_server, text};
use serde_json::Value;

/// A number at a path of names and indices.
#[track_caller]
fn number(of: &Value, path: &str) -> f64 {
    of.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path} in {of}"))
}

/// The columns of these names of a CSV file, line by line.
fn lines(path: &Path, names: &[&str]) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let heads = reader.headers().unwrap().clone();
    let at =
        |name: &&str| heads.iter().position(|h| h == *name).unwrap_or_else(|| panic!("{name}"));
    let places: Vec<usize> = names.iter().map(at).collect();
    let records = reader.records().map(Result::unwrap);
    records.map(|r| places.iter().map(|k| r[*k].to_owned()).collect()).collect()
}

/// Straight ahead at 0.5 m/s for 3 s with a slip of 0.05, 480 seeds.
const SEED_LAB: [&str; 9] = [
    "sweep",
    "patrol",
    "--seeds",
    "0..480",
    "--ticks=30",
    "--set",
    "robot.slip_std=0.05",
    "--set",
    "script={ kind = \"straight\", v_m_s = 0.5 }",
];

#[test]
fn the_seed_lab_grows_as_the_chapter_says() {
    let found = sim_server(&[&SEED_LAB[..], &["--json"]].concat()).expect(0).json();
    let lab = &found["report"]["growth"][0];
    // The chapter's 2.1, 5.7 and 10.1 cm at 1, 2 and 3 s, and 0.5 m driven in each.
    let mut spreads_m = Vec::new();
    for (tick, chapter_m) in [(9, 0.021), (19, 0.057), (29, 0.101)] {
        let sample = &lab["samples"][tick];
        let driven_m = 0.05 * (tick + 1) as f64;
        let distance_m = number(sample, "/distance_m");
        assert!((distance_m / driven_m - 1.0).abs() < 0.005, "{distance_m} for {driven_m}");
        let spread_m = number(sample, "/position_m");
        assert!((spread_m / chapter_m - 1.0).abs() < 0.10, "{spread_m} for {chapter_m}");
        spreads_m.push(spread_m);
    }
    for (k, ratio) in [(1, 2.7), (2, 4.9)] {
        assert!((spreads_m[k] / spreads_m[0] / ratio - 1.0).abs() < 0.08, "{spreads_m:?}");
    }
    let exponent = number(lab, "/exponents/position/law/exponent");
    assert!((1.40..=1.50).contains(&exponent), "{exponent}");
    // Nine in the world frame, more in log coordinates, where nothing bends.
    let last = &lab["samples"][29];
    let nine = number(last, "/across_over_along");
    assert!((8.0..=10.0).contains(&nine), "{nine}");
    let spread = |part: &str| number(last, &format!("/{part}/standard_deviation"));
    assert_eq!(nine, spread("across_m") / spread("along_m"));
    assert!(spread("log_across_m") / spread("log_along_m") > 1.05 * nine);
    // What is printed are these.
    let said = sim_server(&SEED_LAB).expect(0).stdout;
    for words in [format!("{nine:.2}"), format!("position {exponent:.2} ± ")] {
        assert!(said.contains(&words), "{words} is not in {said}");
    }
}

#[test]
fn quantization_alone_is_a_third_of_a_millimetre() {
    let place = folder();
    let out = place.path().join("a.csv");
    let row = |ticks: &str| -> [f64; 2] {
        let all = ["sweep", "patrol", "--seeds=0", "--set=robot.slip_std=0", "--ticks", ticks];
        sim_server(&[&all[..], &["--force", "--out", out.to_str().unwrap()]].concat()).expect(0);
        let line = lines(&out, &["distance_m", "final_position_error_m"]).remove(0);
        [0, 1].map(|k| line[k].parse().unwrap())
    };
    // The first tick is driven, too.
    let [driven_m, error_m] = row("300");
    assert!((driven_m - 14.307).abs() < 1e-9, "{driven_m}");
    assert!((error_m - 1.062_004_987_974e-4).abs() < 1e-12, "{error_m:e}");
    // The tick at which the chapter's 42.6 m are driven, and its 2.9e-4 m.
    let [driven_m, error_m] = row("883");
    assert!((driven_m - 42.6).abs() < 0.05, "{driven_m}");
    assert!((error_m - 2.9e-4).abs() < 0.05e-4, "{error_m:e}");
}

/// Two of the same program, of which one is not told where it starts.
const HIDDEN: &str = "
ticks = 140
world = \"open\"
scan_every = 0
script = { kind = \"straight\", v_m_s = 0.6 }
[[participant]]
name = \"told\"
command = [\"dead-reckoning\"]
[[participant]]
name = \"not-told\"
command = [\"dead-reckoning\"]
map = \"hidden\"
initial_pose = \"hidden\"
[[participant]]
name = \"score\"
role = \"scorer\"
command = [\"score\"]
[[participant]]
name = \"logger\"
role = \"logger\"
command = [\"logger\"]
";

/// The lines of the first table of scores in a text, word by word.
fn table(said: &str) -> Vec<Vec<&str>> {
    let lines = said.lines().skip_while(|line| !line.starts_with("estimator"));
    let lines = lines.take_while(|line| !line.is_empty());
    lines.map(|line| line.split_whitespace().collect()).collect()
}

#[test]
fn who_is_not_told_where_it_starts_is_judged_aligned_and_the_table_says_so() {
    let place = folder();
    let [scenario, out] = ["scenario.toml", "run"].map(|name| place.path().join(name));
    fs::write(&scenario, HIDDEN).unwrap();
    let report = launch("hidden", &out, &[scenario.to_str().unwrap()]);
    let [told, not_told] = [0, 1].map(|k| &report["scores"][k]);
    assert_eq!([text(told, "alignment"), text(not_told, "alignment")], ["none", "se2"]);
    // As it is, it is off by the start; both are in the document.
    assert!(number(not_told, "/final_position_error_m") > 1.0, "{not_told}");
    assert!(number(not_told, "/aligned/final_position_error_m") < 0.1, "{not_told}");
    let [rmse_m, again_m] =
        ["/aligned/ate_rmse_m", "/ate/se2/translation_m/rmse"].map(|path| number(not_told, path));
    assert_eq!(rmse_m, again_m);
    // An error that is no error of driving is no drift.
    assert!(not_told["drift_percent"].is_null() && told["drift_percent"].is_f64());

    let log = out.join("run.log");
    let args = ["--log", log.to_str().unwrap(), "--out", place.path().to_str().unwrap()];
    let said = rusty_tests::Process::start("score", &args).wait().expect(0).stdout;
    let table = table(&said);
    assert_eq!(table[0][..2], ["estimator", "alignment"]);
    assert_eq!(table[1][..2], ["told", "none"]);
    assert_eq!(table[2][..2], ["not-told", "SE(2)"]);
    assert_eq!((table.len(), table[2].last()), (3, Some(&"–")), "{said}");
    let error_m: f64 = table[2][2].parse().unwrap();
    let exact_m = number(not_told, "/aligned/final_position_error_m");
    assert!((error_m / exact_m - 1.0).abs() < 0.05, "{error_m} for {exact_m}");

    // 70 ticks of 0.02 s are 1.4000000000000001 s in doubles.
    let said = sim_server(&["info", log.to_str().unwrap(), "--tick", "69"]).expect(0).stdout;
    assert!(said.contains(" 1.4 s\n") && !said.contains("00000"), "{said}");
}

#[test]
fn a_small_error_has_its_digits_in_every_table() {
    let place = folder();
    let out = place.path().join("run");
    let args = ["launch", "patrol", "--seed=0", "--ticks=300", "--set=robot.slip_std=0"];
    let run = fresh_run("small");
    let all = [&args[..], &["--run", run.as_str(), "--out", out.to_str().unwrap()]].concat();
    let said = sim_server(&all).expect(0).stdout;
    assert_eq!(table(&said)[1][..4], ["dead-reckoning", "none", "1.1e-4", "m"], "{said}");
    let args = ["sweep", "patrol", "--seeds=0", "--ticks=300", "--set=robot.slip_std=0"];
    let swept = sim_server(&args).expect(0).stdout;
    assert!(swept.contains(" 1.1e-4 "), "{swept}");
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("1.1e−4 m"));
}

#[test]
fn a_sweep_with_an_added_estimator_is_launch_with_it() {
    let place = folder();
    let out = place.path().join("a.csv");
    let add = ["--add", "second=dead-reckoning"];
    let patrol = ["sweep", "patrol", "--seeds=4..6", "--ticks=40", "--out", out.to_str().unwrap()];
    sim_server(&[&patrol[..], &["--clients"], &add].concat()).expect(0);
    let rows = lines(&out, &["estimator", "digest"]);
    let names: Vec<&str> = rows.iter().map(|row| row[0].as_str()).collect();
    assert_eq!(names, ["dead-reckoning", "second"].repeat(2));
    let args = [&["patrol", "--seed=5", "--ticks=40"][..], &add].concat();
    let report = launch("added", &place.path().join("run"), &args);
    assert_eq!(rows[2][1], text(&report, "digest"));
    assert_ne!(rows[0][1], rows[2][1]);

    // Nobody waits inside a sweep for what is started by hand.
    let said = sim_server(&[&patrol[..], &["--force", "--clients", "--add=second"]].concat());
    let said = said.expect(2).stderr;
    assert!(said.contains("second") && said.contains("--add NAME=COMMAND"), "{said}");
    let said = sim_server(&[&patrol[..], &["--force"], &add].concat()).expect(2).stderr;
    assert!(said.contains("--clients"), "{said}");
}
