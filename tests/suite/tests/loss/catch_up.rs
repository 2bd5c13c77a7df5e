//! `on_loss = "restart"`: a participant that is killed comes back, is given the run again,
//! and nothing shows it afterwards.

use rusty_tests::*;

const COME_BACK: [&str; 2] = ["--set", "on_loss=restart"];
const DRIVER: [&str; 3] = ["driver", "--add", "dead-reckoning=dead-reckoning"];
/// 400 ticks in about a second.
const TICKS: [&str; 4] = ["--ticks", "400", "--pace", "8"];

/// The same run without a disturbance: its digest and its log.
fn undisturbed(scenario: &[&str]) -> (String, Vec<u8>) {
    let out = folder();
    let args = [scenario, &COME_BACK, &["--ticks", "400"]].concat();
    let report = launch("undisturbed", out.path(), &args);
    assert_eq!(report["restarts"], json!([]));
    (text(&report, "digest").to_owned(), fs::read(out.at("run.log")).unwrap())
}

/// Kills `name` when it has taken part for a while; the number of times.
fn kill(live: &Live, name: &str, times: usize) {
    for _ in 0..times {
        let pid = live.pid_of(name);
        // Long enough to have joined and to be somewhere in the run again.
        std::thread::sleep(Duration::from_millis(150));
        send_signal(pid, Signal::KILL);
        until("the killed one is gone", || participants(&live.run).iter().all(|(p, _)| *p != pid));
    }
}

#[test]
fn whoever_is_killed_comes_back_and_the_run_is_the_same() {
    let (digest, log) = undisturbed(&DRIVER);
    for (name, times) in [("wander", 1), ("dead-reckoning", 2), ("score", 1), ("logger", 1)] {
        let live = Live::under_way("back", &[&DRIVER, &COME_BACK, &TICKS]);
        kill(&live, name, times);
        let after = live.ends_with(0);
        assert_eq!(text(&after.report, "digest"), digest, "{name}");
        assert_eq!(fs::read(after.out.at("run.log")).unwrap(), log, "{name}");
        assert_eq!(after.report["losses"], json!([]), "{name}");
        let restarts = list(&after.report, "restarts");
        assert_eq!(restarts.len(), times, "{restarts:?}");
        assert_eq!((text(&restarts[0], "name"), text(&restarts[0], "kind")), (name, "dead"));
        after.says(&format!("lost: {name} dead"));
        let scores = list(&after.report, "scores");
        assert!(!scores.is_empty(), "{name}");
    }
}

#[test]
fn one_that_is_stopped_for_too_long_is_replaced() {
    let (digest, _) = undisturbed(&[]);
    let timeout = ["--answer-timeout", "0.5"];
    let live = Live::under_way("stopped", &[&COME_BACK, &TICKS, &timeout]);
    send_signal(live.pid_of("dead-reckoning"), Signal::STOP);
    let after = live.ends_with(0);
    assert_eq!(text(&after.report, "digest"), digest);
    assert_eq!(text(&after.report["restarts"][0], "kind"), "stalled");
}

/// A run with a probe that does something at tick 10.
fn run_with(tag: &str, mode: &str, code: i32) -> (Value, Folder) {
    let out = folder();
    let probe = probe("probe", mode);
    let args = ["--add", &probe, "--ticks", "40", COME_BACK[0], COME_BACK[1]];
    (launch_to(tag, out.path(), &args, code), out)
}

#[test]
fn one_can_come_back_more_often_than_there_are_ports() {
    let run = |mode: &str| {
        let out = folder();
        let probe = probe("probe", &format!("{mode} --at 0"));
        let args = ["--add", &probe, "--ticks", "200", COME_BACK[0], COME_BACK[1]];
        launch_to("mayfly", out.path(), &args, 0)
    };
    let report = run("mayfly");
    // A port of the transport is one of 64.
    assert!(list(&report, "restarts").len() > 64, "{}", report["restarts"]);
    assert_eq!(report["digest"], run("none")["digest"]);
}

#[test]
fn one_that_always_dies_at_the_same_place_is_given_up() {
    let (report, _out) = run_with("hopeless", "exit", 1);
    assert_eq!(report["ended"], "aborted");
    assert_eq!(report["ticks"], 10);
    assert_eq!(list(&report, "restarts").len(), 3);
    assert_eq!(text(&report["losses"][0], "name"), "probe");
}

#[test]
fn one_that_does_not_repeat_itself_is_named() {
    let (report, _out) = run_with("fickle", "fickle-and-mortal", 3);
    assert_eq!((&report["ended"], &report["ticks"]), (&Value::from("done"), &Value::from(40)));
    let remarks = report["remarks"].to_string();
    assert!(remarks.contains("probe came back and answers tick 0 otherwise"), "{remarks}");
}

#[test]
fn one_started_by_hand_is_waited_for() {
    let (digest, _) = undisturbed(&[]);
    let live = Live::start("serve", "by-hand", &[&COME_BACK, &TICKS]);
    let others = ["score", "logger"].map(|name| live.join(name, &[]));
    let first = live.join("dead-reckoning", &[]);
    live.until_the_log_has_ticks();
    first.signal(Signal::KILL);
    assert_eq!(first.wait().code, None);
    let second = live.join("dead-reckoning", &[]);
    for client in others.into_iter().chain([second]) {
        client.wait().expect(0);
    }
    let after = live.ends_with(0);
    assert_eq!(text(&after.report, "digest"), digest);
    after.says("start it again");
}

#[test]
fn a_run_that_ends_while_its_logger_catches_up_keeps_what_was_logged() {
    let live = Live::start("launch", "cut-short", &[&COME_BACK, &TICKS, &["--paused"]]);
    until("the run takes steps", || live.control(&["step", "250"]));
    // A tick after a while takes all before it to the disk.
    until("the log is on the disk", || live.control(&["step"]) && written(&live.log()) > 250);
    let saved = written(&live.log());
    let first = live.pid_of("logger");
    send_signal(first, Signal::KILL);
    until("another logger is there", || {
        participants(&live.run).iter().any(|(pid, name)| name == "logger" && *pid != first)
    });
    // Wherever it is on its way back: the run ends.
    let second = live.pid_of("logger");
    send_signal(second, Signal::STOP);
    assert!(live.control(&["stop"]));
    send_signal(second, Signal::CONT);
    let log = live.log();
    let ended = live.server.wait();
    let kept = Log::read(&log);
    let ticks = kept.entries.len();
    assert!(ticks >= saved, "{saved} ticks were saved, {ticks} are left: {ended:#?}");
    let report = ended.json();
    assert!(!kept.is_complete() || report["ticks"] == ticks, "{report}");
    assert!(!log.with_extension("log.again").exists());
}
