//! The conformance kit: what is shipped passes it, and each kind of broken
//! client fails exactly the checks that are about its fault.
//!
//! With `RUSTY_CONFORMANCE=all` the scorer, which draws a picture at the end of
//! every little run, goes through all checks too, and not only those that
//! differ from the logger's.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use rusty_tests::*;

/// Long enough for a busy machine; only what hangs takes so long.
const PATIENT: [&str; 2] = ["--patience", "60"];

/// Runs the kit on a client and expects exit code `code`; fails if it leaves
/// anything behind.
#[track_caller]
fn kit(options: &[&str], client: &[&str], code: i32) -> Value {
    let mut all = vec!["conformance", "--json"];
    all.extend(options);
    all.push("--");
    all.extend(client);
    let process = Process::start("sim-server", &all);
    let pid = process.pid();
    let report = process.wait().expect(code).json();
    nothing_left_by(pid);
    report
}

/// Fails if a run of the kit with this process number has left anything.
#[track_caller]
fn nothing_left_by(pid: u32) {
    for n in 0..64 {
        nothing_left(&RunName::new(&format!("conf-{pid}-{n}")).unwrap());
    }
}

fn checks<'a>(report: &'a Value, verdict: &str) -> Vec<&'a str> {
    let all = list(report, "checks").iter();
    all.filter(|c| c["verdict"] == verdict).map(|c| text(c, "check")).collect()
}

/// What was seen in a check.
#[track_caller]
fn seen<'a>(report: &'a Value, check: &str) -> &'a str {
    let all = list(report, "checks");
    text(all.iter().find(|c| c["check"] == check).unwrap(), "seen")
}

/// Does `work` with all `items`, a few at a time: a run is mostly waiting.
fn together<T: Sync>(items: &[T], work: impl Fn(&T) + Sync) {
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(|| {
                while let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed)) {
                    work(item);
                }
            });
        }
    });
}

#[test]
fn what_is_shipped_passes() {
    // Only the pictures are its own; what it does with frames is the logger's code.
    let scorer = ["damaged-digest", "end", "sigterm", "dying-server"];
    let everything = std::env::var("RUSTY_CONFORMANCE").is_ok_and(|v| v == "all");
    if !everything {
        println!("score: {} checks (RUSTY_CONFORMANCE=all: all)", scorer.len());
    }
    let clients = [
        ("dead-reckoning", "estimator", 1),
        ("01_first_estimator", "estimator", 1),
        ("02_as_a_type", "estimator", 1),
        ("03_driver", "driver", 1),
        ("dead-reckoning", "observer", 8),
        ("logger", "logger", 4),
        ("score", "scorer", 4),
    ];
    together(&clients, |(client, role, not_for_it)| {
        let mut options = vec!["--role", role, "--name", "somebody"];
        options.extend(PATIENT);
        let few = *client == "score" && !everything;
        if few {
            options.extend(scorer.iter().flat_map(|check| ["--only", check]));
        }
        let report = kit(&options, &[arg(&binary(client))], 0);
        assert_eq!(checks(&report, "fail"), [""; 0], "{client}: {report:#}");
        if few {
            assert_eq!(checks(&report, "pass"), scorer);
        } else {
            assert_eq!(checks(&report, "not applicable").len(), *not_for_it, "{client}");
            assert_eq!(report["passed"], 18 - not_for_it, "{client}");
        }
    });
}

/// A fault of the probe, the checks that fail for it, and what the first of
/// them says.
const FAULTS: [(&str, &[&str], &str); 13] = [
    ("", &[], ""),
    ("covariance", &[], ""),
    ("wrong-name", &["joins"], "told was \"client\""),
    ("wrong-protocol", &["joins"], "protocol 3, known is 2"),
    ("wrong-digest", &["answers-every-tick"], "the frame has"),
    ("double", &["answers-every-tick"], "more than one per tick, first to tick 10"),
    ("nan-estimate", &["numbers-are-finite"], "x_m is NaN"),
    ("skew", &["numbers-are-finite"], "covariance[0][1] is 0.005 and covariance[1][0] is 0"),
    ("chance", &["deterministic"], "tick 0: pose"),
    ("integrates", &["doubled-tick"], "tick 6: pose"),
    ("any-run", &["foreign-frame"], "at tick 4"),
    ("last-word", &["answers-every-tick", "early-end"], "first to tick 24"),
    ("bad-code", &["end", "early-end"], "exit code 5"),
];

#[test]
fn each_fault_fails_its_own_checks() {
    let said = Mutex::new(0);
    together(&FAULTS, |(mode, failing, words)| {
        let probe = binary("probe-client");
        let client = [arg(&probe), "--mode", mode];
        let code = i32::from(!failing.is_empty());
        let report = kit(&PATIENT, &client, code);
        assert_eq!(checks(&report, "fail"), *failing, "{mode}: {report:#}");
        if let Some(first) = failing.first() {
            assert!(seen(&report, first).contains(words), "{mode}: {}", seen(&report, first));
        }
        *said.lock().unwrap() += 1;
    });
    assert_eq!(*said.lock().unwrap(), FAULTS.len());
}

#[test]
fn who_ends_in_the_middle_fails_all_that_goes_so_far() {
    let probe = binary("probe-client");
    let probe = arg(&probe);
    // Tick 10 is never reached by these, nor judged by those.
    let untouched = [
        "joins",
        "ready-before-first-frame",
        "numbers-are-finite",
        "scan-shapes",
        "early-end",
        "sigterm",
        "dying-server",
        "refused",
    ];
    together(&[("exit", "exit code 7"), ("panic", "on request")], |(mode, words)| {
        let report = kit(&PATIENT, &[probe, "--mode", mode], 1);
        assert_eq!(checks(&report, "pass"), untouched, "{mode}: {report:#}");
        assert_eq!(checks(&report, "not applicable"), ["deterministic", "damaged-digest"]);
        let at = seen(&report, "answers-every-tick");
        assert!(at.contains("at tick 10") && at.contains(words), "{at}");
    });
}

#[test]
fn single_faults_around_a_run() {
    let probe = binary("probe-client");
    let probe = arg(&probe);
    // Where something must never happen, waiting for it takes the patience.
    let cases = [
        ("needs-map", "hidden-map", "60", "panicked at"),
        ("silent-refusal", "refused", "60", "exit code 0"),
        ("orphan", "dying-server", "5", "still ran"),
        ("hang", "end", "5", "no answer to tick 10"),
        ("linger", "end", "5", "no leave message"),
        ("old-tick", "end", "5", "what came instead"),
    ];
    together(&cases, |(mode, check, patience, words)| {
        let options = ["--only", check, "--patience", patience];
        let report = kit(&options, &[probe, "--mode", mode], 1);
        assert_eq!(checks(&report, "fail"), [*check], "{mode}");
        assert!(seen(&report, check).contains(words), "{mode}: {}", seen(&report, check));
    });
    let joins = |client: &[&str]| kit(&["--only", "joins", "--patience", "0.5"], client, 1);
    let never = joins(&["sh", "-c", "sleep 60"]);
    assert!(seen(&never, "joins").contains("no request to join within 500ms"), "{never}");
    // What a client started itself goes with it.
    let mark = format!("86{}", std::process::id());
    let script = format!("sleep {mark} & echo I am no client; exit 9");
    let gone = joins(&["sh", "-c", &script]);
    let words = seen(&gone, "joins");
    assert!(words.contains("exit code 9") && words.contains("I am no client"), "{words}");
    until("the sleeper is gone", || !processes().iter().any(|(_, words)| words.contains(&mark)));
}

#[test]
fn wrong_usage_is_named() {
    let usage = |args: &[&str], words: &str| {
        sim_server(&[&["conformance"], args].concat()).expect(2).says(words);
    };
    usage(&[], "CLIENT");
    usage(&["--role", "cook", "--", "true"], "use one of: estimator, driver");
    usage(&["--only", "joyns", "--", "true"], "use one of: joins");
    usage(&["--patience", "0", "--", "true"], "--patience");
    usage(&["--name", "a/b", "--", "true"], "a/b");
    sim_server(&["conformance", "--", "no-such-program"]).expect(1).says("no-such-program");
}

#[test]
fn the_table_teaches() {
    let probe = binary("probe-client");
    let client = [arg(&probe), "--mode", "wrong-name"];
    let mut all = vec!["conformance", "--only", "joins", "--only", "refused", "--"];
    all.extend(client);
    let table = sim_server(&all).expect(1).stdout;
    for words in ["fail  joins", "pass  refused", "the rule", "join.rs", "1 passed, 1 failed"] {
        assert!(table.contains(words), "{words:?} is not in\n{table}");
    }
    sim_server(&["conformance", "--list"])
        .expect(0)
        .prints("doubled-tick\n  done      three frames shown twice");
}

#[test]
fn ctrl_c_leaves_nothing() {
    let probe = binary("probe-client");
    let all = ["conformance", "--json", "--patience", "600", "--"];
    let client = [arg(&probe), "--mode", "hang"];
    let process = Process::start("sim-server", &[&all[..], &client].concat());
    let pid = process.pid();
    let first = RunName::new(&format!("conf-{pid}-0")).unwrap();
    until("the first run is open", || Domain::traces(&first).len() > 8);
    process.signal(Signal::INT);
    let report = process.wait().expect(3).json();
    assert_eq!(report["not_made"], 18);
    nothing_left_by(pid);
}
