//! Twenty runs at once and a sweeper next to them: no run disturbs another, and
//! what a dead run left goes while the living go on.

use std::collections::BTreeSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use rusty_tests::*;

const CROWD: usize = 20;

/// A run that was killed with all its participants: no process could sweep.
fn dead_run() -> RunName {
    let live = Live::under_way("dead", &[&LONG]);
    let all = participants(&live.run);
    assert_eq!(all.len(), 3);
    // Stopped first: one that sees the server die would sweep.
    for signal in [Signal::STOP, Signal::KILL] {
        all.iter().for_each(|(pid, _)| send_signal(*pid, signal));
        if signal == Signal::STOP {
            live.server.signal(Signal::KILL);
        }
    }
    let run = live.run;
    assert_eq!(live.server.wait().code, None);
    until("all are dead", || participants(&run).is_empty());
    run
}

#[test]
fn twenty_runs_and_a_sweeper_do_not_disturb_each_other() {
    binaries();
    let (over, removed) = (AtomicBool::new(false), Mutex::new(BTreeSet::new()));
    std::thread::scope(|scope| {
        let _over = Raise(&over);
        scope.spawn(|| {
            while !over.load(Ordering::Relaxed) {
                let report = sim_server(&["clean", "--json"]).expect(0).json();
                let names = list(&report, "removed").clone();
                let names = names.iter().map(|name| name.as_str().unwrap().to_owned());
                removed.lock().unwrap().extend(names);
            }
        });
        // Much faster than a process can be started.
        scope.spawn(|| {
            while !over.load(Ordering::Relaxed) {
                Domain::sweep_dead().unwrap();
                std::thread::sleep(Duration::from_millis(1));
            }
        });
        let few = ["--ticks", "500", "--pace", "1", "--without", "score"];
        let patient = ["--answer-timeout", "100", "--join-timeout", "100"];
        let crowd = [(); CROWD].map(|()| Live::start("launch", "crowd", &[&few, &patient]));
        crowd.iter().for_each(Live::until_the_log_has_ticks);
        // A run has its folder a moment before and after it has its lock, and
        // one that is swept then loses nothing; from here on all have it.
        removed.lock().unwrap().clear();
        let dead = dead_run();
        until("the dead run is swept", || Domain::traces(&dead).is_empty());
        let swept = removed.lock().unwrap().clone();
        let alive = crowd.iter().filter(|live| Domain::find(&live.run).is_ok());
        let alive: BTreeSet<String> = alive.map(|live| live.run.to_string()).collect();
        assert!(swept.is_disjoint(&alive), "{swept:?}");
        println!("{} of {CROWD} runs went on while a dead one was swept", alive.len());
        let mut digests = BTreeSet::new();
        for live in crowd {
            digests.insert(text(&live.ends_with(0).report, "digest").to_owned());
        }
        assert_eq!(digests.len(), 1, "{digests:?}");
    });
}
