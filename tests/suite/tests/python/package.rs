//! The Python package, in real runs: it takes part like any other client, its
//! arrays never show another tick's data, and whatever a script does to leave,
//! the run learns of it.

use rusty_contract::Innovation;
use rusty_tests::python::{python, script};
use rusty_tests::*;

/// `--add` of an estimator that is a script among the tests.
fn adding(python: &Path, file: &str, more: &str) -> String {
    format!("python={} {} {more}", python.display(), script(file))
}

/// Runs a script to its end.
#[track_caller]
fn python_ends(python: &Path, args: &[&str], code: i32) -> Ended {
    Process::spawn(Command::new(python).args(args)).wait().expect(code)
}

#[test]
fn the_package_says_what_it_is_made_for() {
    let Some(python) = python() else { return };
    let said = python_ends(python, &["-m", "rusty"], 0).stdout;
    let layout = sim_server(&["layout", "--json"]).expect(0).json();
    for line in [
        format!("layout {}", text(&layout, "layout_hash")),
        format!("protocol {}", layout["protocol"]),
        format!("rusty {}", env!("CARGO_PKG_VERSION")),
    ] {
        assert!(said.lines().any(|l| l == line), "{line:?} is not in {said}");
    }
    assert!(said.contains("\nnumpy ") && said.contains("\npython 3."), "{said}");
}

#[test]
fn whatever_the_package_offers_says_what_it_is() {
    let Some(python) = python() else { return };
    let said = python_ends(python, &[&script("documented.py")], 0).stdout;
    assert_eq!(said, "documented\n");
}

#[test]
fn a_script_beside_its_scenario_reckons_like_the_rust_client_bit_for_bit() {
    if python().is_none() {
        return;
    }
    let place = folder();
    let example = repository().join("clients/python/examples/dead_reckoning.py");
    fs::copy(example, place.at("my_filter.py")).unwrap();
    let mine = estimator("my-filter", &["python3", "my_filter.py"], "");
    let both = format!("{}\n{mine}", apartment_scenario());
    let scenario = place.write("both.toml", both);
    // A bare `python3` is the one on the path, as for anybody.
    let bin = python().unwrap().parent().unwrap();
    let path = std::env::join_paths(
        std::iter::once(bin.to_owned())
            .chain(std::env::split_paths(&std::env::var_os("PATH").unwrap())),
    );
    let (run, out) = (fresh_run("both"), place.at("run"));
    let mut launch = Command::new(binary("sim-server"));
    launch.args(["launch", "--json", "--ticks", "400", "--run", run.as_str(), "--out"]);
    launch.arg(&out).arg(&scenario).env("PATH", path.unwrap());
    let report = Process::spawn(&mut launch).wait().expect(0).json();
    nothing_left(&run);
    let score = |name: &str| number(score_of(&report, name), "ate_rmse_m");
    assert!(score("my-filter") > 0.0 && score("my-filter") == score("dead-reckoning"));
    let records = records(&out.join("run.log"));
    for record in &records {
        let [rust, python] = record.replies[..] else { panic!("two reply") };
        let same = matches!(rust, Reply::Estimate(_)) && rust.same_bits(&python);
        assert!(same, "tick {}", record.tick);
    }
    assert_eq!(records.len(), 400);
}

#[test]
fn a_kept_scan_stays_what_it_was_and_the_log_shows_the_same() {
    let Some(python) = python() else { return };
    let out = folder();
    launch("keeps", out.path(), &["--ticks", "400", "--add", &adding(python, "keeps.py", "")]);
    let said = fs::read_to_string(out.at("python.txt")).unwrap();
    let seen = said.split_whitespace().nth(1).unwrap();
    let log = out.at("run.log");
    let args = [script("seen.py"), arg(&log).to_owned()];
    let again = python_ends(python, &args.each_ref().map(String::as_str), 0);
    assert_eq!(again.stdout.trim(), seen);
    // The same script on the log: the same arrays, kept and let go of as before.
    let args = [script("keeps.py"), "--log".into(), arg(&log).into(), "--out".into()];
    let csv = out.at("answers.csv");
    let args: Vec<&str> = args.iter().map(String::as_str).chain([arg(&csv)]).collect();
    let kept = python_ends(python, &args, 0);
    kept.says(&format!("seen {seen} "));
    assert_eq!(fs::read_to_string(csv).unwrap().lines().count(), 401);
}

#[test]
fn a_kept_scan_outlives_a_server_that_is_killed() {
    let Some(python) = python() else { return };
    let live = Live::start("serve", "outlives", &[&LONG, &["--add", "python"]]);
    let run = live.run.as_str();
    let mut command = Command::new(python);
    let enough = live.out.at("enough");
    command.args([&script("outlives.py"), "--run", run, "--name", "python"]).arg(&enough);
    let keeper = Process::spawn(&mut command);
    let others = ALL.map(|name| live.join(name, &[]));
    until("it keeps scans", || enough.exists());
    live.server.signal(Signal::KILL);
    let kept = keeper.wait().expect(0);
    assert_eq!(kept.stdout, "unchanged\n", "{kept:?}");
    drop(others.map(Process::wait));
    let run = live.run.clone();
    drop(live.server.wait());
    nothing_left(&run);
}

#[test]
fn a_fork_keeps_the_scans_that_it_has_and_gets_no_others() {
    let Some(python) = python() else { return };
    let out = folder();
    launch("forks", out.path(), &["--ticks", "120", "--add", &adding(python, "forks.py", "")]);
}

#[test]
fn pools_of_workers_end_while_a_run_goes_on() {
    let Some(python) = python() else { return };
    let out = folder();
    launch("pools", out.path(), &["--ticks", "120", "--add", &adding(python, "pools.py", "")]);
}

#[test]
fn what_is_no_answer_is_refused_and_the_tick_goes_on() {
    let Some(python) = python() else { return };
    let out = folder();
    let add = adding(python, "answers.py", "");
    launch("answers", out.path(), &["--ticks", "120", "--add", &add]);
    for record in records(&out.at("run.log")) {
        let (n, reply) = (record.tick, record.replies[1]);
        match n % 4 {
            0 => {
                let Reply::Both(estimate, command) = reply else { panic!("{reply:?}") };
                let covariance = [1.0, 0.5, 0.0, 0.5, 2.0, 0.0, 0.0, 0.0, 3.0];
                assert_eq!(estimate.covariance, Some(covariance));
                assert_eq!(estimate.innovation, Some(Innovation { nis: 2.5, degrees: 4 }));
                assert_eq!(
                    (estimate.pose_in_world.x(), estimate.pose_in_world.y()),
                    (n as f64, -1.5)
                );
                assert_eq!((command.v_m_s, command.omega_rad_s), (0.5, 0.25));
            }
            1 => assert!(reply.command().is_some() && reply.estimate().is_none()),
            _ => assert_eq!(reply, Reply::Abstain),
        }
    }
}

/// Remarks of a report as one text.
fn remarks(report: &Value) -> String {
    report["remarks"].to_string()
}

#[test]
fn whoever_leaves_at_tick_7_has_failed_and_its_last_lines_are_kept() {
    let Some(python) = python() else { return };
    for (how, words) in [
        ("raise", Some("ValueError: boom at seven")),
        ("kept", Some("ValueError: boom at seven")),
        ("log", Some("this is no run log")),
        ("break", None),
        ("exit", None),
    ] {
        let add = adding(python, "leaves.py", how);
        let after = Live::start("launch", "leaves", &[&["--add", &add]]).ends_with(1);
        after.lost("python", "failed", "it reported a failure of its own");
        assert_eq!(after.report["losses"][0]["tick"], 7, "{how}");
        let Some(words) = words else { continue };
        let said = remarks(&after.report);
        let ended = "python: its process exited with code 1; it printed:";
        assert!(said.contains(ended) && said.contains(words), "{how}: {said}");
        let talk = fs::read_to_string(after.out.at("python.txt")).unwrap();
        assert!(talk.starts_with("Traceback (most recent call last):"), "{talk}");
        let last = talk.lines().last().unwrap();
        assert!(talk.contains("in work") && last.contains(words), "{talk}");
    }
}

#[test]
fn a_run_that_goes_on_goes_on_without_a_script_that_raised() {
    let Some(python) = python() else { return };
    let add = adding(python, "leaves.py", "raise");
    let args: [&[&str]; 3] = [&["--ticks", "100"], &GO_ON, &["--add", &add]];
    let after = Live::start("launch", "goes-on", &args).ends_with(3);
    after.lost("python", "failed", "it reported a failure of its own");
    assert!(remarks(&after.report).contains("ValueError: boom at seven"), "{}", after.report);
    let (records, complete) = after.records();
    assert!(complete && records.len() == 100);
    let missing = records.iter().filter(|r| r.replies[1] == Reply::Missing).count();
    assert_eq!(missing, 93);
}

#[test]
fn ctrl_c_ends_waiting_and_leaves() {
    let Some(python) = python() else { return };
    // Paused, so that the script waits for its first tick.
    let live = Live::start("serve", "ctrl-c", &[&["--paused", "--add", "python"]]);
    let joined = live.out.at("joined");
    let mut command = Command::new(python);
    command.args([&script("waits.py"), "--run", live.run.as_str(), "--name", "python"]);
    let script = Process::spawn(command.arg(&joined));
    until("it has joined", || joined.exists());
    script.signal(Signal::INT);
    let ended = script.wait();
    // Python ends by the signal itself, as shells want it.
    assert_eq!(ended.code, None, "{ended:?}");
    assert!(ended.stderr.trim_end().ends_with("KeyboardInterrupt"), "{ended:?}");
    live.ends_with(1).lost("python", "left", "it left before the end");
}

#[test]
fn ctrl_c_in_the_loop_s_body_leaves_however_it_joined() {
    let Some(python) = python() else { return };
    let live = Live::start("serve", "ctrl-c", &[&LONG, &["--add", "python"]]);
    let busy = live.out.at("busy");
    let mut command = Command::new(python);
    let script =
        Process::spawn(command.args([script("interrupted.py")]).arg(live.run.as_str()).arg(&busy));
    let others = ALL.map(|name| live.join(name, &[]));
    until("it is busy", || busy.exists());
    script.signal(Signal::INT);
    assert!(script.wait().stderr.trim_end().ends_with("KeyboardInterrupt"));
    drop(others.map(Process::wait));
    live.ends_with(1).lost("python", "left", "it left before the end");
}

#[test]
fn a_session_that_another_thread_closes_just_ends() {
    let Some(python) = python() else { return };
    let live = Live::start("serve", "closes", &[&["--paused", "--add", "python"]]);
    let mut command = Command::new(python);
    command.args([&script("closes.py"), "--run", live.run.as_str(), "--name", "python"]);
    assert_eq!(Process::spawn(&mut command).wait().expect(0).stdout, "closed\n");
    live.ends_with(1).lost("python", "failed", "it reported a failure of its own");
}

#[test]
fn ctrl_c_ends_joining() {
    let Some(python) = python() else { return };
    let code = "import sys, rusty\nprint('joining', flush=True)\n\
                rusty.join('me', run=sys.argv[1], join_timeout=3600)";
    let run = fresh_run("nowhere");
    let started = folder();
    let said = started.at("said");
    let mut command = Command::new("sh");
    let shell = format!("exec {} -c \"$0\" \"$1\" > {}", python.display(), said.display());
    command.args(["-c", &shell, code, run.as_str()]);
    let joining = Process::spawn(&mut command);
    until("it joins", || fs::read_to_string(&said).is_ok_and(|said| said.contains("joining")));
    joining.signal(Signal::INT);
    let ended = joining.wait();
    assert!(ended.code.is_none() && ended.stderr.contains("KeyboardInterrupt"), "{ended:?}");
    nothing_left(&run);
}

#[test]
fn a_command_line_is_read_as_that_of_any_client() {
    let Some(python) = python() else { return };
    let reckons = repository().join("clients/python/examples/dead_reckoning.py");
    let reckons = arg(&reckons);
    let help = python_ends(python, &[reckons, "--help"], 0);
    assert!(help.stdout.contains("--join-timeout") && help.stderr.is_empty(), "{help:?}");
    let nothing = python_ends(python, &[reckons], 2);
    nothing.says("--run <NAME>");
    nothing.says("rusty.join(run=");
    let absent = python_ends(python, &[reckons, "--log", "/absent/run.log"], 1);
    absent.says("/absent/run.log");
    let run = fresh_run("absent");
    let args = [reckons, "--run", run.as_str(), "--join-timeout", "0.1"];
    let alone = python_ends(python, &args, 1);
    assert!(alone.stderr.starts_with("dead_reckoning.py: "), "{alone:?}");
}

#[test]
fn python_passes_the_conformance_kit() {
    let Some(python) = python() else { return };
    let reckons = repository().join("clients/python/examples/dead_reckoning.py");
    let (python, reckons) = (arg(&python), arg(&reckons));
    let args = ["conformance", "--json", "--patience", "60", "--", python, reckons];
    let ended = sim_server(&args);
    assert_eq!(ended.code, Some(0), "{}", ended.stdout);
}
