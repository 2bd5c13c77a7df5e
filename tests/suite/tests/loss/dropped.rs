//! One that stood still for too long and comes back: it is told that the run
//! goes on without it, ends with a separate word and code, and changes
//! nothing in what the others do.

use rusty_tests::*;

const WORDS: &str = "was dropped from this run";

/// A run by hand that goes on when a participant is lost, after a second.
fn served(tag: &str) -> Live {
    let patient = ["--answer-timeout", "1", "--add", "second"];
    Live::start("serve", tag, &[&SHORT, &GO_ON, &patient])
}

/// Waits until the log has a tick that the first estimator did not answer.
fn until_it_is_lost(log: &Path) {
    use rusty_contract::Reply;
    until("the run goes on without it", || {
        let log = Log::try_read(log);
        log.is_some_and(|log| log.records().iter().any(|r| r.replies.contains(&Reply::Missing)))
    });
}

#[test]
fn a_stopped_estimator_that_comes_back_is_told_and_leaves() {
    for mode in ["stop-holding", "stop-answered"] {
        let live = served("back");
        let args = ["--name", "second", "--mode", mode, "--at", "20"];
        let second = live.join("probe-client", &args);
        let others = ALL.map(|name| live.join(name, &[]));
        until("it stops", || is_stopped(second.pid()));
        until_it_is_lost(&live.log());
        second.signal(Signal::CONT);
        let told = second.wait().expect(3);
        assert!(told.stderr.contains(&format!("\"second\" {WORDS}")), "{mode}: {told:?}");
        assert!(others.map(|other| other.wait().code) == [Some(0); 3]);
        let after = live.ends_with(3);
        after.lost("second", "stalled", "is stopped by a signal; `kill -CONT");
        after.ended("done", 400);
        let calm =
            launch("calm", folder().path(), &["--ticks", "400", "--add", "second=dead-reckoning"]);
        assert_eq!(after.report["world_digest"], calm["world_digest"]);
        assert_eq!(after.verifies(0)["digest"], after.report["digest"]);
    }
}

/// The participants of the SDK, by hand so that their codes can be seen.
#[test]
fn whoever_is_built_with_the_sdk_ends_with_the_code_of_a_loss() {
    for name in ALL {
        let live = served("sdk");
        let second = live.join("probe-client", &["--name", "second"]);
        let mut parts: Vec<(&str, Process)> = ALL.map(|n| (n, live.join(n, &[]))).into();
        live.until_the_log_has_ticks();
        let (_, victim) = parts.remove(parts.iter().position(|(n, _)| *n == name).unwrap());
        victim.signal(Signal::STOP);
        until("it stops", || is_stopped(victim.pid()));
        until_the_server_goes_on(&live, name);
        victim.signal(Signal::CONT);
        victim.wait().expect(3).says(&format!("\"{name}\" {WORDS}"));
        assert_eq!(second.wait().code, Some(0));
        assert!(parts.into_iter().all(|(_, part)| part.wait().code == Some(0)));
        let after = live.ends_with(3);
        after.lost(name, "stalled", "is stopped by a signal; `kill -CONT");
        assert_eq!(after.report["ticks"], 400);
        let (records, complete) = after.records();
        assert_eq!(complete, name != "logger");
        assert!(complete || (1..400).contains(&records.len()), "{}", records.len());
        after.verifies(if complete { 0 } else { 3 });
    }
}

/// What the run answers to one that asks to join under a lost name.
fn until_the_server_goes_on(live: &Live, name: &str) {
    let run: &RunName = &live.run;
    let dropped = format!("{name:?} was dropped from this run (stalled)");
    until("it is lost", || {
        let late = execute("probe-client", &["--run", run.as_str(), "--name", name]);
        late.code == Some(1) && late.stderr.contains(&dropped)
    });
}
