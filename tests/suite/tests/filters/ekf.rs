//! `ekf` as a process: near the truth and right about how near, the same live,
//! from the log and on a replay, and with words where it cannot begin.

use rusty_tests::*;

fn run(tag: &str, out: &Path, args: &[&str]) -> Value {
    launch(tag, out, &[&[filter_scenario("ekf.toml").as_str()][..], args].concat())
}

#[test]
fn it_is_near_knows_how_near_and_says_the_same_again() {
    let place = folder();
    let out = place.at("run");
    let report = run("ekf", &out, &["--ticks", "700"]);
    let score = score_of(&report, "ekf");
    assert!(number(score, "ate_rmse_m") < 0.005, "{score}");
    assert!(number(score, "rmse_heading_error_rad") < 0.5_f64.to_radians(), "{score}");
    assert_eq!(score["nees"]["unusable"], 0);
    assert!(number(score, "nees/mean") < 6.0, "{score}");
    let surprise = number(score, "nis/sum") / number(score, "nis/degrees");
    assert!((0.9..1.1).contains(&surprise), "{score}");

    // Run again on the log, every answer is the same to the bit.
    let log = log_of(&report);
    let verdict = about("verify", &log, &["--clients", "--json"]).expect(0).json();
    let again = named(&verdict["clients"], "participants", "ekf");
    assert_eq!((&again["compared"], &again["equal"]), (&700.into(), &700.into()));
    // And so it is as a process of a replay.
    let replayed = replay(&log, &place.at("replay"), &[]).expect(0).json();
    assert_eq!(replayed["digest"], report["digest"]);
}

#[test]
fn unequal_wheels_lose_dead_reckoning_but_not_the_filter() {
    let place = folder();
    // Open loop, such wheels would drive into a wall.
    let set =
        ["--set", "script.kind=truth-steered-patrol", "--set", "robot.radius_bias_right=0.01"];
    let args = [&["--ticks", "1000", "--without", "logger"][..], &set].concat();
    let report = run("ekf-bias", place.path(), &args);
    let error_m = |name: &str| number(score_of(&report, name), "ate_rmse_m");
    assert!(error_m("ekf") < 0.01, "{}", error_m("ekf"));
    assert!(error_m("dead-reckoning") > 20.0 * error_m("ekf"), "{report}");
}

#[test]
fn without_a_map_it_predicts_and_without_a_start_it_says_what_to_do() {
    let place = folder();
    let text_of = fs::read_to_string(filter_scenario("ekf.toml")).unwrap();
    let with = |line: &str| {
        text_of.replacen("command = [\"ekf\"]", &format!("command = [\"ekf\"]\n{line}"), 1)
    };
    let map = place.write("map.toml", with("map = \"hidden\""));
    let pose = place.write("pose.toml", with("initial_pose = \"hidden\""));

    let out = place.at("run");
    let report = launch("ekf-no-map", &out, &[&map, "--ticks", "200"]);
    assert_eq!(
        score_of(&report, "ekf")["ate_rmse_m"],
        score_of(&report, "dead-reckoning")["ate_rmse_m"]
    );
    let on_log = ["--log", text(&report, "log"), "--name", "ekf"];
    let ended = Process::spawn(Command::new(binary("ekf")).args(on_log)).wait();
    ended.expect(0).says("there is no map with walls");

    let out = place.at("refused");
    let refused = run_to("ekf-no-pose", &out, &["launch", &pose, "--ticks", "20"]);
    assert_ne!(refused.code, Some(0));
    // On standard error if it was printed before the loss was, else among the remarks.
    let words = "is not told where the robot starts";
    assert!(refused.stderr.contains(words) || refused.stdout.contains(words), "{refused:?}");
}

#[test]
fn a_filter_is_as_sure_as_its_data_sheet_lets_it_be() {
    let place = folder();
    // Ranges are 2.5 times as noisy as the data sheet says.
    let run_with = |sheet: &str| {
        let set = ["--ticks", "400", "--set", "lidar.range_std_m=0.05", "--data-sheet", sheet];
        run(&format!("ekf-{sheet}"), &place.at(sheet), &set)
    };
    let reports = ["given", "nominal", "hidden"].map(run_with);
    let surprise = |report: &Value| {
        let score = score_of(report, "ekf");
        number(score, "nis/sum") / number(score, "nis/degrees")
    };
    // Believed is a σ of 5, 2 and 3 cm.
    let [given, nominal, hidden] = [0, 1, 2].map(|k| surprise(&reports[k]));
    assert!((0.85..1.15).contains(&given), "{given}");
    assert!(nominal > 1.2 * hidden && hidden > 1.5 * given, "{given} {nominal} {hidden}");

    for (report, sheet) in reports.iter().zip(["given", "nominal", "hidden"]) {
        let log = log_of(report);
        let info = about("info", &log, &["--json"]).expect(0).json();
        assert_eq!(named(&info, "roster", "ekf")["data_sheet"], sheet);
        about("info", &log, &[]).expect(0).prints(&format!("data sheet {sheet}"));
        // Its clients are told the same again, in a replay as well.
        about("verify", &log, &["--clients"]).expect(0);
        let replayed = replay(&log, &place.at(format!("replay-{sheet}")), &[]).expect(0).json();
        assert_eq!(replayed["digest"], report["digest"]);
    }

    let refused = sim_server(&["launch", "--data-sheet", "secret"]).expect(2);
    refused.says("--data-sheet").says("secret").says("given, nominal or hidden");
}

#[test]
fn wheels_that_do_not_fit_its_model_do_not_mislead_it() {
    let place = folder();
    // People and walls hold the robot, and its wheels turn on.
    let set = ["--set", "robot.radius_bias_right=0.03", "--ticks", "1500"];
    let args = [&["office", "--seed", "1", "--add", "ekf=ekf", "--without", "logger"][..], &set];
    let report = launch("ekf-lost", place.path(), &args.concat());
    let ekf = score_of(&report, "ekf");
    assert!(number(ekf, "scored_ticks") > 1400.0, "{ekf}");
    let error_m = |name: &str| number(score_of(&report, name), "ate_rmse_m");
    assert!(error_m("ekf") < 0.05 && error_m("dead-reckoning") > 1.0, "{report}");
}
