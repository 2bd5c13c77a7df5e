//! One that stood still for too long and comes back: it is told that the run
//! goes on without it, ends with a word and a code of its own, and changes
//! nothing in what the others do.

mod common;

use std::fs;

use common::*;
use rustix::process::Signal;
use rusty_contract::RunName;
use rusty_tests::*;

const WORDS: &str = "was dropped from this run";

/// Whether a process stands still.
fn stands(pid: u32) -> bool {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    stat.rsplit(')').next().is_some_and(|rest| rest.trim_start().starts_with('T'))
}

/// A run by hand that goes on when somebody is lost, after a second.
fn served(tag: &str) -> Live {
    let patient = ["--answer-timeout", "1", "--add", "second"];
    Live::start("serve", tag, &[&SHORT, &GO_ON, &patient])
}

/// Waits until the log has a tick that the first estimator did not answer.
fn until_it_is_lost(log: &std::path::Path) {
    use rusty_contract::log::{LogReader, Read};
    until("the run goes on without it", || {
        let Ok(mut reader) = LogReader::open(log) else { return false };
        while let Ok(Read::Tick(entry)) = reader.read() {
            if entry.record.replies.contains(&rusty_contract::Reply::Missing) {
                return true;
            }
        }
        false
    });
}

#[test]
fn a_stopped_estimator_that_comes_back_is_told_and_leaves() {
    for mode in ["stop-holding", "stop-answered"] {
        let live = served("back");
        let args = ["--name", "second", "--mode", mode, "--at", "20"];
        let second = live.join("probe-client", &args);
        let others = ALL.map(|name| live.join(name, &[]));
        until("it stops", || stands(second.pid()));
        until_it_is_lost(&live.log());
        second.signal(Signal::CONT);
        let told = second.wait().expect(3);
        assert!(told.stderr.contains(&format!("\"second\" {WORDS}")), "{mode}: {told:?}");
        assert!(others.map(|other| other.wait().code) == [Some(0); 3]);
        let after = live.ends_with(3);
        after.lost("second", "stalled", "is stopped by a signal; `kill -CONT");
        assert_eq!((&after.report["ended"], &after.report["ticks"]), (&"done".into(), &400.into()));
        let out = folder();
        let calm =
            launch("calm", out.path(), &["--ticks", "400", "--add", "second=dead-reckoning"]);
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
        until("it stops", || stands(victim.pid()));
        until_the_server_goes_on(&live, name);
        victim.signal(Signal::CONT);
        let told = victim.wait().expect(3);
        assert!(told.stderr.contains(&format!("\"{name}\" {WORDS}")), "{told:?}");
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
        let late = Process::start("probe-client", &["--run", run.as_str(), "--name", name]).wait();
        late.code == Some(1) && late.stderr.contains(&dropped)
    });
}
