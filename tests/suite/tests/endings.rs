//! How runs end: early, twice told, by a server that is killed; and what a
//! damaged log is not turned into.

mod common;

use std::fs;

use common::*;
use rustix::process::Signal;
use rusty_link::Domain;
use rusty_tests::*;
use serde_json::Value;

#[test]
fn a_run_stopped_at_full_speed_counts_the_ticks_its_log_has() {
    let live = Live::under_way("full", &[&["--ticks", "100000000", "--set", "scan_every=0"]]);
    live.server.signal(Signal::INT);
    let after = live.ends_with(3);
    let log = after.out.path().join("run.log");
    let info = sim_server(&["info", "--json", log.to_str().unwrap()]).expect(0).json();
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
        assert!(!after.stderr.contains("no goodbye"), "round {round}: {}", after.stderr);
    }
}

#[test]
fn a_second_signal_ends_the_run_now_and_leaves_nothing() {
    let hang = format!("hang={} --mode hang", binary("probe-client").display());
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
    let scenario =
        fs::read_to_string(repository().join("sim-server/engine/scenarios/apartment.toml"));
    let hidden = "role = \"estimator\"\nmap = \"hidden\"\ninitial_pose = \"hidden\"";
    let place = folder();
    let file = place.path().join("hidden.toml");
    fs::write(&file, scenario.unwrap().replace("role = \"estimator\"", hidden)).unwrap();
    let live = Live::under_way("hidden", &[&[file.to_str().unwrap()], &LONG]);
    let memory = Domain::traces(&live.run);
    let holds = |word: &[u8]| {
        memory
            .iter()
            .filter_map(|path| fs::read(path).ok())
            .any(|bytes| bytes.windows(word.len()).any(|window| window == word))
    };
    assert!(holds(b"\"range_max_m\""), "what a start holds is not found: the search is blind");
    assert!(!holds(b"\"walls\""), "the map is there");
    live.server.signal(Signal::INT);
    live.ends_with(3);
}

#[test]
fn a_damaged_log_does_not_become_a_whole_one() {
    let out = folder();
    launch("damaged", out.path(), &["--ticks", "100"]);
    let log = out.path().join("run.log");
    let mut bytes = fs::read(&log).unwrap();
    // The last byte of the last record but the trailer is part of an estimate.
    let at = bytes.len() - 60;
    bytes[at] ^= 1;
    let damaged = out.path().join("damaged.log");
    fs::write(&damaged, bytes).unwrap();
    let again = folder();
    let args = ["--log", damaged.to_str().unwrap(), "--out", again.path().to_str().unwrap()];
    for client in ["logger", "score"] {
        Process::start(client, &args).wait().expect(3);
    }
    let copy = again.path().join("run.log");
    let info = sim_server(&["info", "--json", copy.to_str().unwrap()]).expect(3).json();
    assert_eq!(info["complete"], false);
}

#[test]
fn a_replay_takes_no_name_twice() {
    let out = folder();
    launch("names", out.path(), &["--ticks", "20"]);
    let log = out.path().join("run.log");
    let to = out.path().join("again");
    let twice = ["--add", "dead-reckoning=dead-reckoning", "--out", to.to_str().unwrap()];
    let ended = sim_server(&[&["replay", log.to_str().unwrap()], &twice[..]].concat()).expect(2);
    assert!(ended.stderr.contains("is there twice"), "{}", ended.stderr);
}

#[test]
fn an_argument_without_sense_is_refused_by_a_participant() {
    for seconds in ["1e19", "nan", "-1"] {
        let timeout = format!("--join-timeout={seconds}");
        let ended = Process::start("dead-reckoning", &["--run", "nobody", &timeout]).wait();
        let ended = ended.expect(2);
        assert!(ended.stderr.contains("--join-timeout"), "{}", ended.stderr);
    }
}

#[test]
fn results_of_an_older_run_do_not_pass_for_new_ones() {
    let out = folder();
    launch("older", out.path(), &["--ticks", "20"]);
    // The harness replaces it.
    let bad = ["--ticks", "20", "--add", "bad=/bin/false"];
    let report = launch_to("newer", out.path(), &bad, 1);
    assert_eq!(report["scores_file"], Value::Null);
    assert!(report["scores"].as_array().unwrap().is_empty());
}
