//! What goes wrong while a run goes on: participants that never come, die,
//! stop, dawdle or leave; a server that is told to stop, or killed. A participant that
//! fails is named with the right word, the rest ends by itself, and nothing is
//! left behind.

use rusty_contract::answer::Message;
use rusty_contract::{Answer, Phase};
use rusty_tests::*;

#[test]
fn one_that_never_joins_is_named_and_the_run_can_go_on_without() {
    let late = "linger --late-ms 600000";
    let timeout = ["--join-timeout", "1", "--ticks", "50"];
    let aborted = with_probe("never", late, &[&timeout]).ends_with(1);
    aborted.lost("dead-reckoning", "never-attached", "it never asked to join");
    aborted.ended("aborted", 0);
    let went_on = with_probe("never", late, &[&timeout, &GO_ON]).ends_with(3);
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
        assert_eq!(after.report["restarts"], json!([]), "{on_loss}");
        // The others end because of it, and that is all.
        assert_eq!(after.report["remarks"], json!([]), "{on_loss}");
        let output = text(&after.report["outputs"], "mine");
        assert!(fs::read_to_string(output).unwrap().contains("--no-such-option"));
        after.says(output);
        assert_eq!(after.report["outputs"].as_object().unwrap().len(), 1);
    }
}

#[test]
fn one_that_dies_is_named_alone_whenever_it_dies() {
    for mode in ["panic --at 0", "panic --at 10", "wrong-layout"] {
        let probe = probe("probe", mode);
        let args = ["--ticks", "50", "--add", &probe];
        let after = Live::start("launch", "alone", &[&args]).ends_with(1);
        assert_eq!(list(&after.report, "losses").len(), 1, "{mode}");
        assert_eq!(after.report["remarks"], json!([]), "{mode}");
    }
}

#[test]
fn a_server_by_itself_says_whom_it_waited_for() {
    let ended = Live::start("serve", "alone", &[&["--join-timeout", "1"]]).ends_with(1);
    for name in ALL {
        ended.says(&format!("lost: {name} never attached"));
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
        // The process that writes the log dies without writing its trailer.
        assert_eq!(complete, name != "logger");
        after.verifies(if complete { 0 } else { 3 });
        if complete {
            assert_eq!(records.len() as u64, after.report["ticks"].as_u64().unwrap());
        }
    }
}

/// A run in which one is killed, and the others go on.
fn going_on_without(name: &str) -> After {
    let live = Live::under_way("kill-on", &[&SHORT, &GO_ON]);
    send_signal(live.pid_of(name), Signal::KILL);
    let after = live.ends_with(3);
    after.lost(name, "dead", "its process was killed by signal 9");
    after
}

#[test]
fn a_run_can_go_on_without_a_killed_estimator() {
    let after = going_on_without("dead-reckoning");
    after.went_on_without_the_estimator();
}

#[test]
fn a_run_can_go_on_without_a_killed_scorer() {
    let after = going_on_without("score");
    assert_eq!((&after.report["ticks"], after.records().1), (&400.into(), true));
    assert_eq!(after.verifies(0)["digest"], after.report["digest"]);
    assert_eq!(after.report["scores"], json!([]));
}

#[test]
fn a_run_can_go_on_without_a_killed_logger_and_its_log_reads_as_far_as_it_goes() {
    let after = going_on_without("logger");
    assert_eq!(after.report["ticks"], 400);
    assert_eq!(list(&after.report, "scores").len(), 1);
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
            let said = fs::read_to_string(out.at(format!("{name}.txt"))).unwrap();
            assert!(
                said.contains("is gone: it ended without announcing the end of the run"),
                "{name}: {said}"
            );
        }
        let after = After { report: Value::Null, stderr: String::new(), out };
        assert!(!after.records().0.is_empty() && !after.records().1);
        after.verifies(3);
        // The name is free again.
        let again = ["launch", "--quiet", "--ticks", "5", "--run", run.as_str(), "--out"];
        let out = folder();
        sim_server(&[&again[..], &[arg(out.path())]].concat()).expect(0);
    }
}

#[test]
fn a_server_that_ends_while_its_participants_come_leaves_nothing() {
    for (signal, code) in [(Signal::INT, Some(3)), (Signal::KILL, None)] {
        // From the first file in shared memory to where a process has a slot.
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
    let after = with_probe("hang", "hang", &[&timeout]).ends_with(1);
    after.lost("dead-reckoning", "stalled", "is running)");
    assert_eq!(after.report["losses"][0]["tick"], 10);
}

#[test]
fn a_slow_participant_gets_a_notice_and_changes_nothing() {
    let slow = "pause --sleep-us 1500000";
    let after = with_probe("slow", slow, &[&["--ticks", "50"]]).ends_with(0);
    let notice = "dead-reckoning is slow: no answer to tick 10 for 1";
    after.says(notice);
    assert_eq!(after.report["participants"][0]["slow"], 1);
    let calm = launch("calm", folder().path(), &["--ticks", "50"]);
    assert_eq!(after.report["digest"], calm["digest"]);
}

#[test]
fn one_that_exits_panics_aborts_or_leaves_is_lost_in_its_own_way() {
    for (mode, kind, words) in [
        ("exit", "dead", "its process exited with code 7"),
        ("panic", "dead", "its process exited with code 101; it printed:"),
        ("abort", "dead", "its process was killed by signal 6"),
        ("leave", "left", "it left before the end"),
    ] {
        let ticks = ["--ticks", "50"];
        let aborted = with_probe("gone", mode, &[&ticks]).ends_with(1);
        aborted.lost("dead-reckoning", kind, words);
        assert_eq!(aborted.report["losses"][0]["tick"], 10, "{mode}");
        assert_eq!(aborted.report["ticks"], 10, "{mode}");
        assert_eq!(aborted.verifies(0)["ticks"], 10, "{mode}");
        let went_on = with_probe("gone", mode, &[&ticks, &GO_ON]).ends_with(3);
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
    let mut link = hand::join(&live.run, "me").unwrap();
    let frame = hand::next_frame(&mut link).unwrap();
    link.answer(&frame, &Message::Reply(Reply::Abstain), false).unwrap();
    live.join("probe-client", &["--name", "stranger"])
        .wait()
        .expect(1)
        .says("no participant \"stranger\"");
    other.signal(Signal::KILL);
    assert_eq!(hand::next_frame(&mut link).unwrap().phase(), Phase::Aborted);
    link.send_raw(Answer::carrying(&Message::Leave)).unwrap();
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
        assert_eq!(after.report["losses"], json!([]));
        // A participant that had not ended with 0 would be a remark.
        assert_eq!(after.report["remarks"], json!([]));
        let (records, complete) = after.records();
        assert!(complete);
        assert_eq!(records.len() as u64, after.report["ticks"].as_u64().unwrap());
        let verdict = after.verifies(0);
        assert_eq!(verdict["digest"], after.report["digest"]);
        let score = json_file(&after.out.at("score.json"));
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
    after.ended("interrupted", 0);
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
    after.lost("dead-reckoning", "left", "it left before the end");
    estimator.says("stopped on request");
    assert_eq!((estimator.code, scorer.code, logger.code), (Some(1), Some(0), Some(3)));
    after.verifies(0);
}

#[test]
fn clean_takes_what_a_dead_run_left_and_leaves_the_living_alone() {
    let [dead, living] = [(); 2].map(|()| Live::start("serve", "clean", &[]));
    for live in [&dead, &living] {
        // Some shared memory next to the folder: its services are there.
        until("it serves", || {
            Domain::find(&live.run).is_ok() && Domain::traces(&live.run).len() > 3
        });
    }
    dead.server.signal(Signal::KILL);
    assert_eq!(dead.server.wait().code, None);
    let report = sim_server(&["clean", "--json"]).expect(0).json();
    nothing_left(&dead.run);
    let alive = list(&report, "alive");
    let entry = alive.iter().find(|a| a["run"] == living.run.as_str()).unwrap();
    assert_eq!(entry["pid"], living.server.pid());
    let clients = ALL.map(|name| living.join(name, &[]));
    living.until_the_log_has_ticks();
    assert!(clients.map(|c| c.wait().code) == [Some(0); 3]);
    living.ends_with(0).verifies(0);
}
