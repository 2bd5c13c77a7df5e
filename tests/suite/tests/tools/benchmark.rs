//! `benchmark`: a result that others can check, and that no filter can cheat.

use rusty_tests::*;

/// Options of a benchmark that is short.
const TINY: [&str; 7] = ["--only", "few-beams", "--track", "odometry", "--seeds", "2", "--quiet"];

/// Whether this kernel can confine in full; prints the reason if it cannot.
fn kernel_can() -> bool {
    let place = folder();
    let entry = estimator("estimator", &["dead-reckoning"], "sandbox = true");
    let file = place.write("s.toml", format!("ticks = 1\n{entry}"));
    let ended = sim_server(&["launch", &file, "--out", arg(&place.at("run")), "--quiet"]);
    let can = ended.code == Some(0);
    if !can {
        skipped(ended.stderr.trim());
    }
    can
}

/// Runs a tiny benchmark with this filter.
fn run(out: &Path, add: &str, more: &[&str]) -> Ended {
    let args = ["benchmark", "run", "--out", arg(out), "--add", add];
    sim_server(&[&args[..], &TINY, more].concat())
}

fn series_client(mode: &str) -> String {
    format!("mine={} {mode}", binary("series-client").display())
}

fn read(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn a_result_is_verified_bit_by_bit_and_what_differs_is_named() {
    if !kernel_can() {
        return;
    }
    let place = folder();
    let (out, mine) = (place.at("mine.json"), series_client(""));
    run(&out, &mine, &[]).expect(0);
    let result = read(&out);
    assert_eq!((&result["confined"], &result["selection"]["whole"]), (&json!(true), &json!(false)));
    let runs = result["runs"].as_array().unwrap();
    let names = |name: &str| runs.iter().filter(|r| r["entry"] == name).count();
    assert_eq!([names("mine"), names("dead-reckoning"), names("scan-match")], [2, 2, 2]);
    // Both are dead reckoning: equal figures, and digests, in which names do not count.
    let figures = |name: &str| {
        let own = runs.iter().filter(|r| r["entry"] == name);
        own.map(|r| (r["figures"].clone(), r["distance_m"].clone())).collect::<Vec<_>>()
    };
    assert_eq!(figures("mine"), figures("dead-reckoning"));
    // Nothing is replaced unasked.
    run(&out, &mine, &[]).expect(2);

    let verify = |file: &Path, add: &[&str]| {
        sim_server(&[&["benchmark", "verify", arg(file), "--json"], add].concat())
    };
    let equal = verify(&out, &["--add", &mine]).expect(0).json();
    assert_eq!((&equal["is_equal"], &equal["runs"]), (&json!(true), &json!(6)));
    assert_eq!(equal["checked"], json!(["mine", "dead-reckoning", "scan-match"]));
    let other = verify(&out, &["--add", "mine=scan-match"]).expect(4).json();
    let named = |found: &Value, place: &str| {
        let all = found["differences"].as_array().unwrap();
        assert!(all.iter().any(|d| d.as_str().unwrap().starts_with(place)), "{found}");
    };
    named(&other, "runs.few-beams/hidden/mine/0.digest");

    // A better score than its runs have, without the program of the filter.
    let mut tampered = result.clone();
    let scores = tampered["scores"].as_array_mut().unwrap();
    scores.iter_mut().find(|s| s["entry"] == "mine").unwrap()["mean"] = json!(0.0001);
    let file = place.write("tampered.json", tampered.to_string());
    let found = verify(Path::new(&file), &[]).expect(4).json();
    named(&found, "scores.few-beams/odometry/mine/");
    assert_eq!(found["unchecked"], json!(["mine"]));
    sim_server(&["benchmark", "report", &file]).expect(4).says("scores.few-beams");
    verify(&out, &["--add", "other=scan-match"]).expect(2).says("other");
}

#[test]
fn several_results_make_a_leaderboard_and_a_page() {
    if !kernel_can() {
        return;
    }
    let place = folder();
    let (a, b, page) = (place.at("a.json"), place.at("b.json"), place.at("page.html"));
    run(&a, &series_client(""), &[]).expect(0);
    run(&b, "theirs=scan-match", &[]).expect(0);
    let report = ["benchmark", "report", arg(&a), arg(&b), "--page", arg(&page), "--json"];
    let board = sim_server(&report).expect(0).json();
    let board: Vec<(&str, &Value)> =
        board.as_array().unwrap().iter().map(|s| (text(s, "entry"), s)).collect();
    let of = |name: &str| board.iter().find(|(entry, _)| *entry == name).unwrap().1;
    assert_eq!(board.len(), 4, "{board:?}");
    assert_eq!(of("dead-reckoning")["is_reference"], json!(true));
    assert_eq!(of("mine")["relative_error"], json!(1.0));
    assert_eq!(of("theirs")["relative_error"], of("scan-match")["relative_error"]);
    let page = fs::read_to_string(&page).unwrap();
    assert!(page.contains("<svg") && page.contains("theirs") && !page.contains("<script"));
    sim_server(&report).expect(2);
    // Other seeds are another benchmark.
    let other = place.at("other.json");
    run(&other, &series_client(""), &["--key", "secret"]).expect(0);
    sim_server(&["benchmark", "report", arg(&a), arg(&other)]).expect(2).says("secret");
}

#[test]
fn a_confined_filter_reaches_no_file_with_the_truth_and_its_failure_is_a_result() {
    if !kernel_can() {
        return;
    }
    let place = folder();
    let truth = place.write("truth.tum", "0.02 1 0 0 0 0 0 1\n");
    let cheat = format!("mine=trajectory {truth}");
    let out = place.at("cheat.json");
    run(&out, &cheat, &[]).expect(3);
    let result = read(&out);
    let runs = result["runs"].as_array().unwrap();
    let failed =
        |name: &str| runs.iter().filter(|r| r["entry"] == name && !r["failure"].is_null()).count();
    assert_eq!([failed("mine"), failed("dead-reckoning")], [2, 0]);
    let own = runs.iter().filter(|r| r["entry"] == "mine");
    assert!(own.clone().all(|r| r["figures"]["rpe-metre"].is_null()), "{result}");
    // The file is readable where it is given. With one answer there is nothing to score.
    let given = place.at("given.json");
    run(&given, &cheat, &["--file", &truth]).expect(0);
    let result = read(&given);
    let score = result["scores"].as_array().unwrap().iter().find(|s| s["entry"] == "mine");
    assert_eq!((&score.unwrap()["without"], &score.unwrap()["mean"]), (&json!(2), &Value::Null));
    // What was not confined is run again like this only if asked for.
    let (free, mine) = (place.at("free.json"), series_client(""));
    run(&free, &mine, &["--unconfined"]).expect(0);
    let verify = ["benchmark", "verify", arg(&free), "--add", &mine, "--quiet"];
    sim_server(&verify).expect(2).says("--unconfined");
    sim_server(&[&verify[..], &["--unconfined"]].concat()).expect(0);
    sim_server(&["benchmark", "report", arg(&free)]).expect(0).prints("mine (unconfined)");
    let mut huge = read(&free);
    huge["selection"]["seeds"] = json!(1u64 << 60);
    let huge = place.write("huge.json", huge.to_string());
    sim_server(&["benchmark", "report", &huge]).expect(2).says("--seeds");
}

/// The log of a short run.
fn logged(place: &Folder, seed: &str) -> PathBuf {
    let out = place.at(seed);
    let args = ["launch", "apartment", "--seed", seed, "--ticks", "300", "--quiet", "--out"];
    sim_server(&[&args[..], &[arg(&out)]].concat()).expect(0);
    out.join("run.log")
}

#[test]
fn recordings_are_runs_that_only_the_same_files_verify() {
    if !kernel_can() {
        return;
    }
    let place = folder();
    let [one, two] = ["1", "2"].map(|seed| logged(&place, seed));
    let (out, mine) = (place.at("recorded.json"), series_client(""));
    let logs = ["--log", arg(&one), "--log", arg(&two)];
    let args = ["benchmark", "run", "--add", &mine, "--only", "recordings", "--quiet"];
    let own = ["--track", "odometry", "--out", arg(&out)];
    sim_server(&[&args[..], &own, &logs].concat()).expect(0);
    let result = read(&out);
    let names: Vec<&str> = result["selection"]["recordings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|log| log["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["run", "run"]);
    let runs = result["runs"].as_array().unwrap();
    let of = |entry: &str, seed: u64| {
        let mut all =
            runs.iter().filter(|r| (&r["entry"], &r["seed"]) == (&json!(entry), &json!(seed)));
        all.next().unwrap()
    };
    assert!(!result["verdicts"].to_string().contains(" seeds"));
    // Both are dead reckoning, as in the runs that were recorded.
    for (seed, log) in [(0, &one), (1, &two)] {
        let (mine, baseline) = (of("mine", seed), of("dead-reckoning", seed));
        assert_eq!((&mine["figures"], &mine["ticks"]), (&baseline["figures"], &json!(300)));
        let own = read(&log.with_file_name("score.json"));
        assert_eq!(mine["distance_m"], own["scores"][0]["distance_m"]);
    }
    assert_ne!(of("mine", 0)["figures"], of("mine", 1)["figures"]);
    let verify = |logs: &[&str]| {
        let args = ["benchmark", "verify", arg(&out), "--add", &mine, "--json", "--quiet"];
        sim_server(&[&args[..], logs].concat())
    };
    // In any order.
    let turned = [&logs[2..], &logs[..2]].concat();
    let equal = verify(&turned).expect(0).json();
    assert_eq!((&equal["is_equal"], &equal["runs"]), (&json!(true), &json!(6)));
    verify(&logs[..2]).expect(2).says("--log");
    let board = sim_server(&["benchmark", "report", arg(&out), "--json"]).expect(0).json();
    let mut mine = board.as_array().unwrap().iter().filter(|s| s["entry"] == "mine");
    assert_eq!(mine.next().unwrap()["answered"], 1.0);
    // Answers that are called by the name of a log are those of one.
    let by_name = ["--add", "theirs=trajectory {run}.tum", "--out", arg(&out), "--force"];
    sim_server(&[&args[..], &by_name, &logs].concat()).expect(2).says(logs[3]).says("rename");
    let broken = place.write("broken.log", "no log");
    let other = place.at("x.json");
    let refused = ["--out", arg(&other), "--log", &broken];
    sim_server(&[&args[..], &refused].concat()).expect(2).says("broken.log");
}

#[test]
fn a_log_counts_once_and_whole_and_with_true_poses() {
    let place = folder();
    let (one, other, key) = (logged(&place, "1"), place.at("x.json"), place.at("key"));
    let whole = fs::read(&one).unwrap();
    let again = place.write("again.log", &whole);
    let cut = place.write("cut.log", &whole[..whole.len() * 3 / 4]);
    let blind = place.at("blind.log");
    sim_server(&["seal", arg(&one), "-o", arg(&blind), "--key-file", arg(&key)]).expect(0);
    for (log, says) in [(&*again, "twice"), (&cut, "cut off"), (arg(&blind), "blind")] {
        let args = ["benchmark", "run", "--add", "mine=dead-reckoning", "--only", "recordings"];
        let logs = ["--out", arg(&other), "--log", arg(&one), "--log", log];
        sim_server(&[&args[..], &logs].concat()).expect(2).says(says);
    }
    assert!(!other.exists());
}

#[test]
fn a_sealed_suite_is_answered_blind_and_scored_like_a_run_of_the_program() {
    if !kernel_can() {
        return;
    }
    let place = folder();
    let (suite, answers, out) = (place.at("suite"), place.at("answers"), place.at("out.json"));
    let of = ["--only", "few-beams", "--seeds", "2", "--key", "secret"];
    let seal = [&["benchmark", "seal", "--json", "--out", arg(&suite)], &of[..]].concat();
    let sealed = sim_server(&seal).expect(0).json();
    let names = ["given-0", "hidden-0", "given-1", "hidden-1"];
    assert_eq!(sealed["runs"], json!(names.map(|name| format!("few-beams-{name}"))));
    sim_server(&seal).expect(2).says("suite");
    let none = place.at("none");
    let driving = ["benchmark", "seal", "--out", arg(&none), "--track", "driving"];
    sim_server(&driving).expect(2).says("driving");
    assert!(!none.exists());
    assert_eq!(fs::read_to_string(suite.join("keys/key.txt")).unwrap(), "secret\n");
    let log = |name: &str| suite.join(format!("blind/few-beams-{name}.log"));
    for (name, has_map) in [("given-0", true), ("hidden-0", false)] {
        let log = log(name);
        let header = rusty_contract::log::LogReader::open(&log).unwrap().header().clone();
        assert_eq!((header.seed(), header.roster.len()), (None, 0));
        assert_eq!(
            (header.known_start().is_some(), header.known_world().is_some()),
            (true, has_map)
        );
        sim_server(&["verify", arg(&log)]).expect(0);
    }

    let (mine, logs) = (series_client(""), ["hidden-0", "hidden-1"].map(log));
    let answer = ["benchmark", "answer", arg(&logs[0]), arg(&logs[1]), "--out", arg(&answers)];
    let answered =
        sim_server(&[&answer[..], &["--add", &mine, "--json"]].concat()).expect(0).json();
    assert_eq!(answered.as_array().unwrap().len(), 2);
    let theirs = format!("theirs=trajectory {}/{{run}}.tum", answers.display());
    let files = ["--add", &theirs, "--file", arg(&answers), "--key", "secret"];
    run(&out, &mine, &files).expect(0);
    let result = read(&out);
    let figures = |name: &str| {
        let runs = result["runs"].as_array().unwrap().iter();
        let own = runs.filter(|r| r["entry"] == name).map(|r| &r["figures"]);
        own.flat_map(|f| ["rpe-metre", "final"].map(|m| f[m].as_f64().unwrap())).collect::<Vec<_>>()
    };
    let (direct, handed_in) = (figures("mine"), figures("theirs"));
    assert_eq!((direct.len(), direct[1] == direct[3]), (4, false));
    // The heading went through a quaternion.
    let is_near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-9;
    assert!(direct.iter().zip(&handed_in).all(is_near), "{direct:?} {handed_in:?}");
    let verify = ["benchmark", "verify", arg(&out), "--add", &theirs, "--file", arg(&answers)];
    sim_server(&verify).expect(0);

    // A filter that is lost has no trajectory, and its run fails.
    let lost = place.at("lost");
    let args = ["benchmark", "answer", arg(&logs[0]), "--add", "mine=false", "--out", arg(&lost)];
    sim_server(&args).expect(3).says("few-beams-hidden-0");
    assert!(!lost.exists(), "an empty folder is in the way of the next attempt");
    // Trajectories are called by the names of their logs.
    fs::create_dir(place.at("other")).unwrap();
    let same = place.at("other").join(logs[0].file_name().unwrap());
    fs::copy(&logs[1], &same).unwrap();
    let answer = ["benchmark", "answer", arg(&logs[0]), arg(&same), "--out", arg(&lost)];
    let refused = sim_server(&[&answer[..], &["--add", &mine]].concat()).expect(2);
    refused.says(arg(&same)).says("rename");
    assert!(!lost.exists());
}

#[test]
fn drivers_are_timed_on_their_way_to_goals() {
    if !kernel_can() {
        return;
    }
    let place = folder();
    let out = place.at("drivers.json");
    let (slow, ends) = ("slow=goto --speed-m-s 0.3", "ends=goto --end");
    let drivers = ["--driver", slow, "--driver", ends];
    let args = ["benchmark", "run", "--out", arg(&out), "--seeds", "1", "--quiet"];
    let only = ["--only", "errand", "--only", "through-people"];
    sim_server(&[&args[..], &only, &drivers].concat()).expect(0);
    let result = read(&out);
    assert_eq!(result["selection"]["tracks"], json!(["driving"]));
    let figures = |scenario: &str, entry: &str| -> Value {
        let mut runs = result["runs"].as_array().unwrap().iter();
        let own = runs.find(|run| run["scenario"] == scenario && run["entry"] == entry);
        own.unwrap()["figures"].clone()
    };
    for scenario in ["errand", "through-people"] {
        let [goto, slow, ends] = ["goto", "slow", "ends"].map(|name| figures(scenario, name));
        let time_s = |of: &Value| number(of, "goals");
        assert!(time_s(&slow) > time_s(&goto) && time_s(&goto) > 20.0, "{slow} {goto}");
        assert!(number(&goto, "goals-driven") > 10.0, "{goto}");
        // A run that ends where its driver is there has not failed.
        assert_eq!(ends, goto);
    }
    let verify = |drivers: &[&str]| {
        let args = ["benchmark", "verify", arg(&out), "--json", "--quiet"];
        sim_server(&[&args[..], drivers].concat())
    };
    assert_eq!(verify(&drivers).expect(0).json()["runs"], json!(6));
    let found = verify(&["--driver", "slow=goto --speed-m-s 0.31"]).expect(4).json();
    assert!(found["differences"][0].as_str().unwrap().contains("slow"), "{found}");
    verify(&["--add", slow]).expect(2).says("--add slow");
}

#[test]
fn a_driver_that_is_not_there_in_time_has_no_time() {
    if !kernel_can() {
        return;
    }
    let place = folder();
    let out = place.at("late.json");
    let late = "late=goto --speed-m-s 0.1";
    let args = ["benchmark", "run", "--out", arg(&out), "--only", "errand", "--seeds", "1"];
    sim_server(&[&args[..], &["--driver", late, "--quiet"]].concat()).expect(0);
    let result = read(&out);
    let of = |list: &str| result[list].as_array().unwrap().clone();
    let score = of("scores").into_iter().find(|s| s["entry"] == "late").unwrap();
    let counts = ["runs", "failed", "without"].map(|field| score[field].as_u64().unwrap());
    assert_eq!((counts, &score["mean"]), ([0, 0, 1], &Value::Null));
    let verdict = of("verdicts").into_iter().find(|v| v["decides"] == true).unwrap();
    assert_eq!(verdict["wins"], json!([1, 0]), "{verdict}");
}

#[test]
fn a_benchmark_that_is_stopped_writes_nothing() {
    if !kernel_can() {
        return;
    }
    let place = folder();
    let (out, mine) = (place.at("out.json"), series_client(""));
    let args = ["benchmark", "run", "--out", arg(&out), "--add", &mine, "--only", "tour"];
    let process = Process::start("sim-server", &[&args[..], &["--jobs", "2"]].concat());
    let pid = process.pid();
    let crew = |number: u32| RunName::new(&format!("sweep-{pid}-{number}")).unwrap();
    until("both crews are at work", || (0..2).all(|n| participants(&crew(n)).len() >= 3));
    process.signal(Signal::INT);
    process.wait().expect(3).says("no result is written");
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 0);
    (0..2).for_each(|number| nothing_left(&crew(number)));
}

#[test]
fn options_that_cannot_be_used_are_refused_before_the_first_run() {
    let place = folder();
    let out = place.at("out.json");
    let refused = |add: &str, more: &[&str], says: &str| {
        let args = ["benchmark", "run", "--out", arg(&out), "--add", add];
        sim_server(&[&args[..], more].concat()).expect(2).says(says);
    };
    refused("mine=x", &["--only", "few-beam"], "did you mean \"few-beams\"?");
    refused("mcl=x", &[], "in use");
    refused("mine", &[], "NAME=COMMAND");
    refused("mine=x", &["--only", "global", "--track", "slam"], "slam");
    refused("mine=x", &["--track", "driving"], "another track");
    refused("mine=x", &["--driver", "mine=y"], "--driver");
    assert!(!out.exists());
    let list = sim_server(&["benchmark", "list", "--json"]).expect(0).json();
    assert_eq!(list["scenario"].as_array().unwrap().len(), 13);
    let file = place.write("x.json", "{}");
    sim_server(&["benchmark", "report", &file]).expect(2).says("x.json");
}

#[test]
fn a_filter_that_uses_the_clock_is_named() {
    if !kernel_can() {
        return;
    }
    // With two jobs each crew makes one of the two runs.
    for jobs in ["1", "2"] {
        let place = folder();
        let ended = run(&place.at("r.json"), &series_client("--mode clock"), &["--jobs", jobs]);
        ended.expect(4).says("mine, seed");
        assert!(!place.at("r.json").exists());
    }
}
