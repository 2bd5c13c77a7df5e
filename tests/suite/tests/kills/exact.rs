//! Kills at exact moments inside the transport: the process ends itself there.

use rusty_tests::*;

const TIMEOUTS: [&str; 4] = ["--answer-timeout", "60", "--join-timeout", "60"];
const LIMIT: Duration = Duration::from_secs(40);

#[test]
fn a_participant_that_dies_with_a_frame_in_its_hand_or_out_of_it_is_dead() {
    for (mode, at) in
        [("kill-holding", 10), ("kill-answered", 10), ("kill-released", 10), ("kill-last", 50)]
    {
        for go_on in [false, true] {
            let policy: &[&str] = if go_on { &GO_ON } else { &[] };
            let live = with_probe("exact", mode, &[&["--ticks", "50"], &TIMEOUTS, policy]);
            let after = live.ends_with(if go_on || at == 50 { 3 } else { 1 });
            after.lost("dead-reckoning", "dead", "its process was killed by signal 9");
            let tick = after.report["losses"][0]["tick"].as_u64().unwrap();
            // The answer was the last thing it did; the death may show later.
            assert!(
                (at..=at + u64::from(mode != "kill-holding")).contains(&tick),
                "{mode}: {tick}"
            );
            if at == 50 {
                assert_eq!((&after.report["ended"], tick), (&"done".into(), 50));
                after.verifies(0);
            } else if go_on {
                after.went_on_without_the_estimator();
            } else {
                assert_eq!(after.report["ticks"], tick);
                assert_eq!(after.verifies(0)["ticks"], tick);
            }
        }
    }
}

#[test]
fn a_death_after_leaving_is_a_remark_and_no_loss() {
    let after = with_probe("exact", "kill-leave", &[&["--ticks", "50"], &TIMEOUTS]).ends_with(3);
    assert_eq!(after.report["losses"], json!([]));
    let remarks = after.report["remarks"].to_string();
    assert!(remarks.contains("dead-reckoning: its process was killed by signal 9"), "{remarks}");
    after.verifies(0);
}

#[test]
fn one_that_dies_while_it_joins_is_dead_and_not_missing() {
    for number in cases("RUSTY_KILLS", 20).take(200) {
        let after = Dice::of("joining", number).time(Duration::from_millis(25)).as_micros();
        let mode = format!("kill-joining --sleep-us {after} --at 100000");
        let ticks = ["--ticks", "1000000", "--set", "scan_every=0"];
        let after = with_probe("joining", &mode, &[&ticks, &TIMEOUTS]).ends_with(1);
        after.lost("dead-reckoning", "dead", "its process was killed by signal 9");
    }
}

#[test]
fn one_that_was_launched_does_not_wait_for_a_server_that_was_killed_meanwhile() {
    // The start of any other run may have swept what the server left.
    for swept in [false, true] {
        let place = folder();
        let script = place.at("late.sh");
        let go = place.at("go");
        let wait = format!("while [ ! -e {:?} ]; do sleep 0.02; done", go);
        let late = format!("exec {:?} --join-timeout 600 \"$@\"", binary("dead-reckoning"));
        fs::write(&script, format!("{wait}\n{late}\n")).unwrap();
        let add = format!("late=sh {}", script.display());
        let live = Live::start("launch", "late", &[&["--add", &add], &ALONE, &TIMEOUTS]);
        live.pid_of("late");
        until("it is served", || Domain::traces(&live.run).len() > 3);
        live.server.signal(Signal::KILL);
        assert_eq!(live.server.wait_within(LIMIT).code, None);
        if swept {
            Domain::sweep_dead().unwrap();
            nothing_left(&live.run);
        }
        fs::write(go, "").unwrap();
        until_within(LIMIT, "it has ended", || participants(&live.run).is_empty());
        nothing_left(&live.run);
        let said = fs::read_to_string(live.out.at("late.txt")).unwrap();
        let gone = "is gone: it ended without announcing the end of the run";
        assert!(said.contains(gone), "{swept}: {said}");
    }
}

/// A log of two estimators, played by `probe-server`.
#[test]
fn a_server_that_dies_inside_the_transport_is_missed_and_swept_by_everyone() {
    let out = folder();
    let second = ["--add", "second=dead-reckoning", "--without", "score"];
    launch("played", out.path(), &[&["--ticks", "30"], &second[..]].concat());
    let log = out.at("run.log");
    for mode in
        ["domain", "services", "asked", "ready", "loan", "sent", "answer", "answers", "last"]
    {
        let run = fresh_run("exact");
        let args = ["--run", run.as_str(), "--log", arg(&log), "--mode", mode];
        let server = Process::start("probe-server", &args);
        if matches!(mode, "domain" | "services") {
            // No process knows of it yet: what it leaves is swept by the next start.
            assert_eq!(server.wait_within(LIMIT).code, None, "{mode}");
            let (again, place) = (["launch", "--ticks", "5", "--run", run.as_str()], folder());
            let place = arg(place.path());
            sim_server(&[&again[..], &["--out", place]].concat()).expect(0);
        } else {
            let clients = ["dead-reckoning", "second"].map(|name| {
                let args = ["--run", run.as_str(), "--name", name, "--join-timeout", "20"];
                Process::start("dead-reckoning", &args)
            });
            assert_eq!(server.wait_within(LIMIT).code, None, "{mode}");
            for client in clients {
                let ended = client.wait_within(LIMIT);
                let told = ended.code == Some(0) && mode == "last";
                let missed = ended.code == Some(1)
                    && ["is gone: it ended without announcing the end of the run", "no run"]
                        .iter()
                        .any(|words| ended.stderr.contains(words));
                assert!(told || missed, "{mode}: {ended:#?}");
            }
            if mode == "last" {
                // Told that all is over, they may have left before it died.
                Domain::sweep_dead().unwrap();
            }
        }
        assert_eq!(participants(&run), [], "{mode}");
        nothing_left(&run);
    }
    assert!(fs::metadata(log).is_ok());
}
