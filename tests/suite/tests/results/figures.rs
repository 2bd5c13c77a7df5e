//! Figures through the commands: those of the chapter, and the same name, digits and
//! alignment wherever a figure is shown.

use rusty_tests::*;

#[test]
fn quantization_alone_is_a_third_of_a_millimetre() {
    let place = folder();
    let out = place.at("a.csv");
    let row = |ticks: &str| -> [f64; 2] {
        let all = ["sweep", "patrol", "--seeds=0", "--set=robot.slip_std=0", "--ticks", ticks];
        sim_server(&[&all[..], &["--force", "--out", arg(&out)]].concat()).expect(0);
        let rows = Table::read(&out);
        ["distance_m", "final_position_error_m"].map(|name| rows.numbers(name)[0])
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
    let [scenario, out] = ["scenario.toml", "run"].map(|name| place.at(name));
    fs::write(&scenario, format!("{HIDDEN}{RECORDERS}")).unwrap();
    let report = launch("hidden", &out, &[arg(&scenario)]);
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
    let args = ["--log", arg(&log), "--out", arg(place.path())];
    let said = execute("score", &args).expect(0).stdout;
    let table = table(&said);
    assert_eq!(table[0][..2], ["estimator", "alignment"]);
    assert_eq!(table[1][..2], ["told", "none"]);
    assert_eq!(table[2][..2], ["not-told", "SE(2)"]);
    assert_eq!((table.len(), table[2].last()), (3, Some(&"–")), "{said}");
    let error_m: f64 = table[2][2].parse().unwrap();
    let exact_m = number(not_told, "/aligned/final_position_error_m");
    assert!((error_m / exact_m - 1.0).abs() < 0.05, "{error_m} for {exact_m}");

    // 70 ticks of 0.02 s are 1.4000000000000001 s in doubles.
    let said = sim_server(&["info", arg(&log), "--tick", "69"]).expect(0).stdout;
    assert!(said.contains(" 1.4 s\n") && !said.contains("00000"), "{said}");
}

#[test]
fn a_small_error_has_its_digits_in_every_table() {
    let place = folder();
    let out = place.at("run");
    let args = ["launch", "patrol", "--seed=0", "--ticks=300", "--set=robot.slip_std=0"];
    let all = [&args[..], &["--out", arg(&out)]].concat();
    let said = sim_server(&all).expect(0).stdout;
    assert_eq!(table(&said)[1][..4], ["dead-reckoning", "none", "1.1e-4", "m"], "{said}");
    let args = ["sweep", "patrol", "--seeds=0", "--ticks=300", "--set=robot.slip_std=0"];
    sim_server(&args).expect(0).prints(" 1.1e-4 ");
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("1.1e−4 m"));
}

#[test]
fn a_sweep_with_an_added_estimator_is_launch_with_it() {
    let place = folder();
    let out = place.at("a.csv");
    let add = ["--add", "second=dead-reckoning"];
    let patrol = ["sweep", "patrol", "--seeds=4..6", "--ticks=40", "--out", arg(&out)];
    sim_server(&[&patrol[..], &["--clients"], &add].concat()).expect(0);
    let rows = Table::read(&out);
    let digests = rows.column("digest");
    assert_eq!(rows.column("estimator"), ["dead-reckoning", "second"].repeat(2));
    let args = [&["patrol", "--seed=5", "--ticks=40"][..], &add].concat();
    let report = launch("added", &place.at("run"), &args);
    assert_eq!(digests[2], text(&report, "digest"));
    assert_ne!(digests[0], digests[2]);

    // A sweep does not wait inside for what is started by hand.
    let said = sim_server(&[&patrol[..], &["--force", "--clients", "--add=second"]].concat());
    let said = said.expect(2).stderr;
    assert!(said.contains("second") && said.contains("--add NAME=COMMAND"), "{said}");
    sim_server(&[&patrol[..], &["--force"], &add].concat()).expect(2).says("--clients");
}
