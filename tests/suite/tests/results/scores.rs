//! Scores of living runs and of their logs: equal in every bit but for how long
//! answers took, and with a verdict for those alone who said how sure they are.

use rusty_tests::*;

const RUN: &str = "
ticks = 400
seed = 3

[[kidnapping]]
tick = 150
to = { x_m = 2.0, y_m = 1.5, theta_rad = 0.0 }

[[participant]]
name = \"careful\"
command = [\"04_covariance\"]

[[participant]]
name = \"silent\"
command = [\"dead-reckoning\"]

[[participant]]
name = \"surprised\"
command = [\"surprised-client\"]

[[participant]]
name = \"late\"
command = [\"surprised-client\"]
compute = { answer_s = 0.1 }
";

/// `score.json` of a log, judged like this.
fn of_log(log: &Path, args: &[&str]) -> Value {
    let out = folder();
    let all = ["--log", arg(&log), "--out", arg(out.path())];
    execute("score", &[&all, args].concat()).expect(0).prints("NEES");
    json_file(&out.at("score.json"))
}

/// How many answers of each participant have an innovation, by the log.
fn innovations(log: &Path) -> Vec<u64> {
    let mut counts = vec![0; 4];
    for record in records(log) {
        for (count, reply) in counts.iter_mut().zip(&record.replies) {
            *count += u64::from(reply.estimate().is_some_and(|e| e.innovation.is_some()));
        }
    }
    counts
}

#[test]
fn a_living_run_and_its_log_have_the_same_scores() {
    let out = folder();
    let recorders = RECORDERS.replace("[\"score\"]", "[\"score\", \"--level\", \"0.9\"]");
    let scenario = out.write("scenario.toml", format!("{RUN}{recorders}"));
    let report = launch("scores", &out.at("run"), &[&scenario]);
    let log = out.at("run/run.log");
    let live = &report["scores"];
    let again = of_log(&log, &["--level", "0.9"]);
    assert_eq!(again["scores"], timeless(live), "the log says otherwise");
    for (score, same) in live.as_array().unwrap().iter().zip(list(&again, "scores")) {
        assert_eq!(same["compute"], Value::Null, "a log knows no durations");
        for times in [&score["compute"]["reported"], &score["compute"]["observed"]] {
            let [p50, p99, max] = ["p50_s", "p99_s", "max_s"].map(|key| number(times, key));
            assert!(0.0 < p50 && p50 <= p99 && p99 <= max, "{times}");
        }
        for errors in [&score["ate"]["none"], &score["ate"]["origin"], &score["ate"]["se2"]] {
            assert_eq!(errors["translation_m"]["count"], score["scored_ticks"]);
        }
        assert_eq!(score["ate"]["none"]["translation_m"]["rmse"], score["ate_rmse_m"]);
        assert_eq!(score["rpe"]["per_tick"]["translation_m"]["rmse"], score["rpe_rmse_m"]);
        // Who only counts wheels is never found again.
        let found = &score["convergence"];
        assert_eq!(found["recoveries"][0]["kidnapped_at_tick"], 150);
        assert_eq!(found["recoveries"][0]["after_s"], Value::Null);
        assert!(number(found, "position_rmse_m") < number(score, "ate_rmse_m"));
    }
    // Careful, silent, surprised, late.
    let [careful, silent, surprised, late] = [0, 1, 2, 3].map(|i| &live[i]);
    assert_eq!((&silent["nees"], &silent["nis"]), (&Value::Null, &Value::Null));
    assert_eq!((&careful["nees"]["samples"], &careful["nis"]), (&400.into(), &Value::Null));
    assert_eq!(careful["nees"]["verdict"], "overconfident", "nobody told it of the kidnapping");
    assert_eq!(careful["nees"]["level"], 0.9);
    // Its first covariance is none; what is late has it for as long as it lasts.
    assert_eq!(surprised["nees"]["unusable"], 1);
    assert_ne!(late["nees"]["mean"], surprised["nees"]["mean"]);
    // Innovations count when they are said.
    let said = innovations(&log);
    assert!(said[2] > 50 && said[0] + said[1] == 0, "{said:?}");
    assert_eq!((&surprised["nis"]["samples"], &late["nis"]), (&said[2].into(), &surprised["nis"]));
}

#[test]
fn without_a_report_the_scores_are_the_same_and_nothing_is_drawn() {
    let (drawn, bare) = (folder(), folder());
    let args = ["--ticks", "60", "--seed", "3"];
    let whole = launch("drawn", drawn.path(), &args);
    let plain = launch("bare", bare.path(), &[&args[..], &["--no-report"]].concat());
    assert_eq!(whole["digest"], plain["digest"]);
    for file in ["report.html", "report.svg", "report.png"] {
        assert!(drawn.at(file).exists() && !bare.at(file).exists(), "{file}");
    }
    // But for times, which no two runs share.
    let figures = |out: &Folder| {
        let score = json_file(&out.at("score.json"))["scores"][0].take();
        ["final_position_error_m", "ate_rmse_m", "distance_m"].map(|name| score[name].clone())
    };
    assert_eq!(figures(&drawn), figures(&bare));
    assert!(figures(&bare).iter().all(Value::is_number), "{:?}", figures(&bare));
    assert!(json_file(&bare.at("score.json"))["report"].is_null());
}

#[test]
fn what_estimates_are_judged_by_is_said_and_wrong_numbers_are_refused() {
    let (_out, log) = logged("judged", &["--ticks", "100"]);
    let strict = of_log(&log, &["--within-m", "1e-9", "--within-deg", "1", "--hold-s", "0.5"]);
    let found = &strict["scores"][0]["convergence"];
    assert_eq!(
        (&found["within"]["position_m"], &found["within"]["hold_s"]),
        (&1e-9.into(), &0.5.into())
    );
    assert_eq!(number(found, "within/heading_rad"), 1f64.to_radians());
    assert_eq!(found["after_s"], Value::Null);
    let plain = of_log(&log, &[]);
    assert_eq!(plain["scores"][0]["convergence"]["after_s"], 0.02);

    let log = arg(&log);
    for (flag, value, words) in [
        ("--level", "95", "0.95 for 95 %"),
        ("--within-m", "0", "greater than 0"),
        ("--within-deg", "nan", "at most 180"),
        ("--hold-s=-1", "", "0 or more"),
    ] {
        let args = ["--log", log, flag, value];
        let count = if value.is_empty() { 3 } else { 4 };
        let ended = execute("score", &args[..count]).expect(2);
        assert!(ended.stderr.contains(words), "{flag}: {}", ended.stderr);
    }
}

/// The fourth example believes in wheels that slip by 2 %.
#[test]
fn who_believes_in_the_slip_there_is_is_consistent_and_who_does_not_is_told() {
    let verdict = |slip: &str| {
        let out = folder();
        let add = format!("careful={}", binary("04_covariance").display());
        let slip = format!("robot.slip_std={slip}");
        let args = ["--ticks", "1500", "--set", &slip, "--without", "logger", "--add", &add];
        let report = launch("slip", out.path(), &args);
        let careful = score_of(&report, "careful");
        println!("{slip}: {}", careful["nees"]);
        text(&careful["nees"], "verdict").to_owned()
    };
    assert_eq!(verdict("0.02"), "consistent");
    assert_eq!(verdict("0.2"), "overconfident");
    assert_eq!(verdict("0.0"), "conservative");
}
