//! How runs end: early, twice told, by a server that is killed; and what a
//! damaged log is not turned into.

use rusty_tests::*;

#[test]
fn a_run_stopped_at_full_speed_counts_the_ticks_its_log_has() {
    let live = Live::under_way("full", &[&["--ticks", "100000000", "--set", "scan_every=0"]]);
    live.server.signal(Signal::INT);
    let after = live.ends_with(3);
    let info = about("info", &after.log(), &["--json"]).expect(0).json();
    assert_eq!(after.report["ended"], "interrupted");
    assert_eq!(after.report["ticks"], info["ticks"]);
    assert_eq!(after.report["digest"], info["digest"]);
    assert_eq!(info["ticks_planned"], 100_000_000);
}

#[test]
fn whoever_waits_in_whatever_way_ends_with_a_killed_server() {
    for how in ["spin", "block"] {
        let roster = ["--without", "score", "--wait", how];
        let live = Live::under_way("spin", &[&LONG, &roster]);
        live.server.signal(Signal::KILL);
        until("everyone has ended", || participants(&live.run).is_empty());
        nothing_left(&live.run);
    }
}

#[test]
fn a_participant_that_ends_at_once_ends_the_run_and_nobody_is_blamed_beside_it() {
    for round in 0..5 {
        let bad = ["--add", "bad=/bin/false"];
        let after = Live::start("launch", "bad", &[&bad]).ends_with(1);
        after.lost("bad", "dead", "exited with code 1");
        let remarks = after.report["remarks"].to_string();
        assert!(!remarks.contains("did not end by itself"), "round {round}: {remarks}");
        assert!(!after.stderr.contains("no leave message"), "round {round}: {}", after.stderr);
    }
}

#[test]
fn a_second_signal_ends_the_run_now_and_leaves_nothing() {
    let hang = probe("hang", "hang");
    let live = Live::start("launch", "twice", &[&["--add", &hang, "--answer-timeout", "600"]]);
    until("all have joined", || participants(&live.run).len() == 4);
    let served = || Domain::find(&live.run).is_ok();
    until("it is served", served);
    live.server.signal(Signal::INT);
    live.server.signal(Signal::TERM);
    until("everyone has ended", || participants(&live.run).is_empty());
    let (run, server) = (live.run, live.server);
    assert_eq!(server.wait().code, Some(3));
    nothing_left(&run);
}

#[test]
fn a_hidden_map_is_in_no_memory_although_a_scorer_has_it() {
    let hidden = "role = \"estimator\"\nmap = \"hidden\"\ninitial_pose = \"hidden\"";
    let place = folder();
    let scenario = apartment_scenario().replace("role = \"estimator\"", hidden);
    let file = place.write("hidden.toml", scenario);
    let live = Live::under_way("hidden", &[&[&file], &LONG]);
    let memory = Domain::traces(&live.run);
    let is_there = |word: &[u8]| memory.iter().flat_map(fs::read).any(|file| holds(&file, word));
    assert!(is_there(b"\"range_max_m\""), "what a start holds is not found: the search is blind");
    assert!(!is_there(b"\"walls\""), "the map is there");
    live.server.signal(Signal::INT);
    live.ends_with(3);
}

#[test]
fn a_damaged_log_does_not_become_a_whole_one() {
    let (out, log) = logged("damaged", &["--ticks", "100"]);
    let mut bytes = fs::read(&log).unwrap();
    // The last byte of the last record but the trailer is part of an estimate.
    let at = bytes.len() - 60;
    bytes[at] ^= 1;
    let damaged = out.at("damaged.log");
    fs::write(&damaged, bytes).unwrap();
    let again = folder();
    let args = ["--log", arg(&damaged), "--out", arg(again.path())];
    for client in ["logger", "score"] {
        execute(client, &args).expect(3);
    }
    let copy = again.at("run.log");
    let info = about("info", &copy, &["--json"]).expect(3).json();
    assert_eq!(info["complete"], false);
}

#[test]
fn a_replay_takes_no_name_twice() {
    let (out, log) = logged("names", &["--ticks", "20"]);
    let to = out.at("again");
    let twice = ["--add", "dead-reckoning=dead-reckoning", "--out", arg(&to)];
    sim_server(&[&["replay", arg(&log)], &twice[..]].concat()).expect(2).says("is there twice");
}

#[test]
fn an_argument_without_sense_is_refused_by_a_participant() {
    for seconds in ["1e19", "nan", "-1"] {
        let timeout = format!("--join-timeout={seconds}");
        let ended = execute("dead-reckoning", &["--run", "nobody", &timeout]);
        ended.expect(2).says("--join-timeout");
    }
}

#[test]
fn results_of_an_older_run_do_not_pass_for_new_ones() {
    let out = folder();
    launch("older", out.path(), &["--ticks", "20"]);
    // The harness replaces it.
    let bad = ["--ticks", "20", "--add", "bad=/bin/false"];
    let report = launch_to("newer", out.path(), &bad, 1);
    assert!(list(&report, "scores").is_empty());
    // A scorer that joined before the loss has scored no tick.
    if let Some(file) = report["scores_file"].as_str() {
        assert_eq!(json_file(Path::new(file))["ticks"], 0);
    }
    launch("older", out.path(), &["--ticks", "20"]);
    let report = launch("newer", out.path(), &["--ticks", "20", "--without", "score"]);
    assert_eq!(report["scores_file"], Value::Null);
    assert!(list(&report, "scores").is_empty());
}
