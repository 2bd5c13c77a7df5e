//! What goes wrong while a run goes on: participants that never come, die,
//! stop, dawdle or leave; a server that is told to stop, or killed. Whoever
//! fails is named with the right word, the rest ends by itself, and nothing is
//! left behind.

mod common;

use std::fs;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use common::*;
use rustix::process::Signal;
use rusty_contract::answer::Message;
use rusty_contract::{Answer, JoinRequest, Phase, Reply};
use rusty_link::{ClientLink, Domain, Incoming, WaitPolicy};
use rusty_tests::*;
use serde_json::Value;

#[test]
fn one_that_never_joins_is_named_and_the_run_can_go_on_without() {
    let late = "linger --late-ms 600000";
    let timeout = ["--join-timeout", "1", "--ticks", "50"];
    let aborted = with_probe("launch", "never", late, &[&timeout]).ends_with(1);
    aborted.lost("dead-reckoning", "never-attached", "it never asked to join");
    assert_eq!(
        (&aborted.report["ended"], &aborted.report["ticks"]),
        (&"aborted".into(), &0.into())
    );
    let went_on = with_probe("launch", "never", late, &[&timeout, &GO_ON]).ends_with(3);
    went_on.lost("dead-reckoning", "never-attached", "it never asked to join");
    assert_eq!(went_on.report["ticks"], 50);
    went_on.verifies(0);
}

#[test]
fn one_without_a_command_is_named_at_once_with_the_program_of_its_name() {
    binaries();
    let timeout = ["--join-timeout", "1", "--ticks", "50", "--add", "mcl", "--add", "ghost"];
    let after = Live::start("launch", "no-command", &[&timeout]).ends_with(1);
    let waiting = |name: &str| {
        let mut lines = after.stderr.lines();
        lines.find(|l| l.starts_with(&format!("waiting for {name},"))).unwrap().to_owned()
    };
    assert!(waiting("mcl").contains("--add mcl=mcl"), "{}", after.stderr);
    assert!(!waiting("ghost").contains("--add"), "no such program: {}", after.stderr);
    let (said, lost) = (after.stderr.find("waiting for mcl"), after.stderr.find("lost: mcl"));
    assert!(said.unwrap() < lost.unwrap(), "{}", after.stderr);
}

#[test]
fn a_program_that_is_misused_is_named_alone_with_its_words_and_its_output() {
    // Once is enough: with the same arguments it would end the same way again.
    for on_loss in ["abort", "restart"] {
        let misused = format!("mine={} --no-such-option", binary("dead-reckoning").display());
        let set = format!("on_loss={on_loss}");
        let args = ["--ticks", "50", "--add", &misused, "--set", &set];
        let after = Live::start("launch", "misused", &[&args]).ends_with(1);
        after.lost("mine", "dead", "its process exited with code 2; it printed:");
        let detail = text(&after.report["losses"][0], "detail");
        assert!(detail.contains("error: unexpected argument '--no-such-option'"), "{detail}");
        assert_eq!(after.report["restarts"], Value::Array(vec![]), "{on_loss}");
        // The others end because of it, and that is all.
        assert_eq!(after.report["remarks"], Value::Array(vec![]), "{on_loss}");
        let output = text(&after.report["outputs"], "mine");
        assert!(fs::read_to_string(output).unwrap().contains("--no-such-option"));
        assert!(after.stderr.contains(output), "{}", after.stderr);
        assert_eq!(after.report["outputs"].as_object().unwrap().len(), 1);
    }
}

#[test]
fn one_that_dies_is_named_alone_whenever_it_dies() {
    for mode in ["panic --at 0", "panic --at 10", "wrong-layout"] {
        let probe = format!("probe={} --mode {mode}", binary("probe-client").display());
        let args = ["--ticks", "50", "--add", &probe];
        let after = Live::start("launch", "alone", &[&args]).ends_with(1);
        assert_eq!(after.report["losses"].as_array().unwrap().len(), 1, "{mode}");
        assert_eq!(after.report["remarks"], Value::Array(vec![]), "{mode}");
    }
}

#[test]
fn a_server_by_itself_says_whom_it_waited_for() {
    let ended = Live::start("serve", "alone", &[&["--join-timeout", "1"]]).ends_with(1);
    for name in ALL {
        assert!(ended.stderr.contains(&format!("lost: {name} never attached")), "{}", ended.stderr);
    }
}

#[test]
fn a_killed_participant_ends_the_run_and_the_log_holds_what_was() {
    for name in ALL {
        let live = Live::under_way("kill", &[&LONG]);
        send_signal(live.pid_of(name), Signal::KILL);
        let after = live.ends_with(1);
        after.lost(name, "dead", "its process was killed by signal 9");
        assert_eq!(after.report["ended"], "aborted");
        let (records, complete) = after.records();
        assert!(!records.is_empty());
        // Whoever writes the log takes its trailer into the grave.
        assert_eq!(complete, name != "logger");
        after.verifies(if complete { 0 } else { 3 });
        if complete {
            assert_eq!(records.len() as u64, after.report["ticks"].as_u64().unwrap());
        }
    }
}

#[test]
fn a_run_can_go_on_without_a_killed_estimator() {
    let live = Live::under_way("kill-on", &[&SHORT, &GO_ON]);
    send_signal(live.pid_of("dead-reckoning"), Signal::KILL);
    let after = live.ends_with(3);
    after.lost("dead-reckoning", "dead", "its process was killed by signal 9");
    after.went_on_without_the_estimator();
}

#[test]
fn a_run_can_go_on_without_a_killed_scorer() {
    let live = Live::under_way("kill-on", &[&SHORT, &GO_ON]);
    send_signal(live.pid_of("score"), Signal::KILL);
    let after = live.ends_with(3);
    after.lost("score", "dead", "its process was killed by signal 9");
    assert_eq!((&after.report["ticks"], after.records().1), (&400.into(), true));
    assert_eq!(after.verifies(0)["digest"], after.report["digest"]);
    assert_eq!(after.report["scores"], Value::Array(vec![]));
}

#[test]
fn a_run_can_go_on_without_a_killed_logger_and_its_log_reads_as_far_as_it_goes() {
    let live = Live::under_way("kill-on", &[&SHORT, &GO_ON]);
    send_signal(live.pid_of("logger"), Signal::KILL);
    let after = live.ends_with(3);
    after.lost("logger", "dead", "its process was killed by signal 9");
    assert_eq!(after.report["ticks"], 400);
    assert_eq!(after.report["scores"].as_array().unwrap().len(), 1);
    let (records, complete) = after.records();
    assert!(!complete && !records.is_empty() && records.len() < 400);
    assert_eq!(after.verifies(3)["ticks"], records.len());
}

#[test]
fn when_the_server_is_killed_everyone_else_ends_and_sweeps() {
    for victim in [Signal::KILL, Signal::ABORT] {
        let live = Live::under_way("server", &[&LONG]);
        assert_eq!(participants(&live.run).len(), 3);
        live.server.signal(victim);
        until("everyone has ended", || participants(&live.run).is_empty());
        nothing_left(&live.run);
        let (run, out) = (live.run, live.out);
        assert_eq!(live.server.wait().code, None);
        for name in ALL {
            let said = fs::read_to_string(out.path().join(format!("{name}.txt"))).unwrap();
            assert!(said.contains("is gone: it ended without a last word"), "{name}: {said}");
        }
        let after = After { report: Value::Null, stderr: String::new(), out };
        assert!(!after.records().0.is_empty() && !after.records().1);
        after.verifies(3);
        // The name is free again.
        let again = ["launch", "--quiet", "--ticks", "5", "--run", run.as_str(), "--out"];
        let out = folder();
        sim_server(&[&again[..], &[out.path().to_str().unwrap()]].concat()).expect(0);
    }
}

#[test]
fn a_server_that_ends_while_its_participants_come_leaves_nothing() {
    for (signal, code) in [(Signal::INT, Some(3)), (Signal::KILL, None)] {
        // From the first file in shared memory to where somebody has a seat.
        let all = [1, 4, 8, 16].map(|traces| {
            let live = Live::start("launch", "start", &[&LONG]);
            until("a participant starts", || {
                !participants(&live.run).is_empty() && Domain::traces(&live.run).len() >= traces
            });
            live.server.signal(signal);
            live
        });
        for live in all {
            assert_eq!(live.server.wait().code, code);
            until("everyone has ended", || participants(&live.run).is_empty());
            nothing_left(&live.run);
        }
    }
}

#[test]
fn a_stopped_participant_is_stalled_and_not_dead() {
    let live = Live::under_way("stop", &[&LONG, &["--answer-timeout", "1"]]);
    send_signal(live.pid_of("dead-reckoning"), Signal::STOP);
    let after = live.ends_with(1);
    after.lost("dead-reckoning", "stalled", "is stopped by a signal; `kill -CONT");
    after.verifies(0);
}

#[test]
fn a_run_can_go_on_without_a_stopped_participant() {
    let live = Live::under_way("stop-on", &[&SHORT, &GO_ON, &["--answer-timeout", "1"]]);
    send_signal(live.pid_of("dead-reckoning"), Signal::STOP);
    let after = live.ends_with(3);
    after.lost("dead-reckoning", "stalled", "is stopped by a signal");
    after.went_on_without_the_estimator();
}

#[test]
fn one_that_hangs_is_stalled_and_its_process_runs() {
    let timeout = ["--answer-timeout", "1", "--ticks", "50"];
    let after = with_probe("launch", "hang", "hang", &[&timeout]).ends_with(1);
    after.lost("dead-reckoning", "stalled", "is running)");
    assert_eq!(after.report["losses"][0]["tick"], 10);
}

#[test]
fn a_slow_participant_gets_a_notice_and_changes_nothing() {
    let slow = "pause --sleep-us 1500000";
    let after = with_probe("launch", "slow", slow, &[&["--ticks", "50"]]).ends_with(0);
    let notice = "dead-reckoning is slow: no answer to tick 10 for 1";
    assert!(after.stderr.contains(notice), "{}", after.stderr);
    assert_eq!(after.report["participants"][0]["slow"], 1);
    let out = folder();
    let calm = launch("calm", out.path(), &["--ticks", "50"]);
    assert_eq!(after.report["digest"], calm["digest"]);
}

#[test]
fn one_that_exits_panics_aborts_or_leaves_is_lost_in_its_own_way() {
    for (mode, kind, words) in [
        ("exit", "dead", "its process exited with code 7"),
        ("panic", "dead", "its process exited with code 101; it printed:"),
        ("abort", "dead", "its process was killed by signal 6"),
        ("goodbye", "left", "it said goodbye before the end"),
    ] {
        let ticks = ["--ticks", "50"];
        let aborted = with_probe("launch", "gone", mode, &[&ticks]).ends_with(1);
        aborted.lost("dead-reckoning", kind, words);
        assert_eq!(aborted.report["losses"][0]["tick"], 10, "{mode}");
        assert_eq!(aborted.report["ticks"], 10, "{mode}");
        assert_eq!(aborted.verifies(0)["ticks"], 10, "{mode}");
        let went_on = with_probe("launch", "gone", mode, &[&ticks, &GO_ON]).ends_with(3);
        went_on.lost("dead-reckoning", kind, words);
        went_on.went_on_without_the_estimator();
    }
}

#[test]
fn nobody_waits_for_the_clock_of_a_slow_run() {
    // A tick in 2000 s: whatever waited for the next one would hang.
    let roster = ["--add", "me", "--without", "score", "--without", "logger"];
    let live = Live::start("serve", "clock", &[&["--pace", "0.00001"], &roster]);
    let other = live.join("dead-reckoning", &[]);
    let (stop, patience) = (AtomicBool::new(false), Duration::from_secs(60));
    let request = JoinRequest::new("me", std::process::id(), 0, "test");
    let mut link =
        ClientLink::join(&live.run, &request, WaitPolicy::Block, patience, &stop).unwrap();
    let next = |link: &mut ClientLink| match link.wait_frame(patience, &stop).unwrap() {
        Incoming::Frame(frame) => frame,
        Incoming::Nothing => panic!("no frame came"),
    };
    let frame = next(&mut link);
    link.answer(&frame, &Message::Reply(Reply::Abstain)).unwrap();
    let stranger = live.join("probe-client", &["--name", "stranger"]).wait().expect(1);
    assert!(stranger.stderr.contains("no participant \"stranger\""), "{}", stranger.stderr);
    other.signal(Signal::KILL);
    assert_eq!(next(&mut link).phase(), Phase::Aborted);
    link.send_raw(Answer::carrying(&Message::Goodbye)).unwrap();
    drop((frame, link));
    live.ends_with(1).lost("dead-reckoning", "dead", "its process has ended");
    assert_eq!(other.wait().code, None);
}

#[test]
fn a_server_that_is_told_to_stop_tells_the_others_and_finishes_its_files() {
    for signal in [Signal::INT, Signal::TERM] {
        let live = Live::under_way("told", &[&LONG]);
        live.server.signal(signal);
        let after = live.ends_with(3);
        assert_eq!(after.report["ended"], "interrupted");
        assert_eq!(after.report["losses"], Value::Array(vec![]));
        // A participant that had not ended with 0 would be a remark.
        assert_eq!(after.report["remarks"], Value::Array(vec![]));
        let (records, complete) = after.records();
        assert!(complete);
        assert_eq!(records.len() as u64, after.report["ticks"].as_u64().unwrap());
        let verdict = after.verifies(0);
        assert_eq!(verdict["digest"], after.report["digest"]);
        let score: Value =
            serde_json::from_slice(&fs::read(after.out.path().join("score.json")).unwrap())
                .unwrap();
        assert_eq!(score["digest"], after.report["digest"]);
        assert_eq!(score["ticks"], after.report["ticks"]);
    }
}

#[test]
fn a_server_that_still_waits_for_others_can_be_stopped() {
    let live = Live::start("serve", "early", &[]);
    until("the run is there", || Domain::find(&live.run).is_ok());
    let client = live.join("dead-reckoning", &["--name", "dead-reckoning"]);
    until("it has opened its ports", || {
        Domain::traces(&live.run).iter().filter(|p| p.to_string_lossy().ends_with(".data")).count()
            > 1
    });
    live.server.signal(Signal::INT);
    let client = client.wait();
    let after = live.ends_with(3);
    assert_eq!(
        (&after.report["ended"], &after.report["ticks"]),
        (&"interrupted".into(), &0.into())
    );
    assert!(matches!(client.code, Some(0 | 1)), "{client:?}");
}

#[test]
fn a_participant_that_is_stopped_by_hand_says_so_and_is_named() {
    let live = Live::start("serve", "hand", &[&LONG]);
    let clients = ALL.map(|name| live.join(name, &[]));
    live.until_the_log_has_ticks();
    clients[0].signal(Signal::INT);
    let [estimator, scorer, logger] = clients.map(Process::wait);
    let after = live.ends_with(1);
    after.lost("dead-reckoning", "left", "it said goodbye before the end");
    assert!(estimator.stderr.contains("stopped on request"), "{estimator:?}");
    assert_eq!((estimator.code, scorer.code, logger.code), (Some(1), Some(0), Some(3)));
    after.verifies(0);
}

/// Raises the flag when it goes.
struct Guard<'a>(&'a AtomicBool);

impl Drop for Guard<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

#[test]
fn two_runs_and_a_sweeper_do_not_disturb_each_other() {
    let done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !done.load(Ordering::Relaxed) {
                sim_server(&["clean", "--json"]).expect(0).json();
            }
        });
        // Much faster than a process can be started.
        scope.spawn(|| {
            while !done.load(Ordering::Relaxed) {
                Domain::sweep_dead().unwrap();
            }
        });
        // Ends the sweepers even if a run fails.
        let _guard = Guard(&done);
        let mut digests = Vec::new();
        for _ in 0..6 {
            let pair = [(); 2].map(|()| Live::start("launch", "pair", &[&["--ticks", "200"]]));
            for live in pair {
                digests.push(text(&live.ends_with(0).report, "digest").to_owned());
            }
        }
        assert!(digests.iter().all(|d| *d == digests[0]), "{digests:?}");
    });
}

#[test]
fn clean_takes_what_a_dead_run_left_and_leaves_the_living_alone() {
    let [dead, living] = [(); 2].map(|()| Live::start("serve", "clean", &[]));
    for live in [&dead, &living] {
        // Some shared memory beside the folder: its services are there.
        until("it serves", || {
            Domain::find(&live.run).is_ok() && Domain::traces(&live.run).len() > 3
        });
    }
    dead.server.signal(Signal::KILL);
    assert_eq!(dead.server.wait().code, None);
    let report = sim_server(&["clean", "--json"]).expect(0).json();
    nothing_left(&dead.run);
    let alive = report["alive"].as_array().unwrap();
    let entry = alive.iter().find(|a| a["run"] == living.run.as_str()).unwrap();
    assert_eq!(entry["pid"], living.server.pid());
    let clients = ALL.map(|name| living.join(name, &[]));
    living.until_the_log_has_ticks();
    assert!(clients.map(|c| c.wait().code) == [Some(0); 3]);
    living.ends_with(0).verifies(0);
}
