//! Benches are tools like others: they measure what they say, mark what is not
//! to be believed, stop when asked to, and leave nothing behind. No test here
//! looks at how long something took.

use rusty_bench::usage::Usage;
use rusty_tests::*;

/// Few ticks, whatever the machine does meanwhile.
const BRIEFLY: [&str; 8] =
    ["--ticks", "200", "--repeat", "2", "--scan-every", "0,2", "--beams", "180"];

fn latency(args: &[&str]) -> Ended {
    let mut all = vec!["bench", "latency", "--quiet", "--json"];
    all.extend(BRIEFLY);
    all.extend(args);
    sim_server(&all)
}

#[test]
fn a_tick_is_measured_beside_the_transport_and_the_floor() {
    let report = latency(&["--clients", "1,2", "--accept-noise"]).expect(0).json();
    assert_eq!(report["bench"], "latency");
    assert_eq!(text(&report, "results_hash").len(), 16);
    let rows = report["results"]["rows"].as_array().unwrap();
    let cases: Vec<(f64, f64)> =
        rows.iter().map(|row| (number(row, "/clients"), number(row, "/scan_every"))).collect();
    assert_eq!(cases, [(1.0, 0.0), (1.0, 2.0), (2.0, 0.0), (2.0, 2.0)]);
    for row in rows {
        for what in ["", "raw_", "floor_"] {
            let figure = |name: &str| number(row, &format!("/{what}{name}"));
            assert_eq!(figure("count"), 400.0);
            assert!(0.0 < figure("p50_ns") && figure("p50_ns") <= figure("max_ns"), "{row}");
            assert!(figure("clients_cpu_ns") > 0.0, "{row}");
        }
        assert!(number(row, "/tick_over_raw/median") > 0.0);
        let is_counted = !text(row, "system_calls").starts_with("not counted");
        assert_eq!(is_counted, row["system_calls_per_tick"].is_number(), "{row}");
    }
}

#[test]
fn the_mix_has_a_scorer_and_a_logger() {
    let args = ["--clients", "1", "--mix", "--accept-noise", "--wait", "block"];
    let report = latency(&args).expect(0).json();
    let rows = report["results"]["rows"].as_array().unwrap();
    assert_eq!(
        text(rows.last().unwrap(), "name"),
        "estimator, scorer, logger, 180 beams in every 2th tick"
    );
    assert_eq!(number(rows.last().unwrap(), "/clients"), 3.0);
    assert!(rows.iter().all(|row| row["over_dead_reckoning"].is_null()));
}

#[test]
fn another_program_is_measured_in_the_place_of_dead_reckoning() {
    let first = binary("01_first_estimator");
    let args = ["--clients", "1", "--accept-noise", "--beside", arg(&first)];
    let report = latency(&args).expect(0).json();
    let rows = report["results"]["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4);
    for pair in rows.chunks(2) {
        let [before, row] = pair else { panic!("{pair:?}") };
        let name = format!("{}, with {}", text(before, "name"), first.display());
        assert_eq!(text(row, "name"), name);
        assert_eq!(number(row, "/count"), 400.0);
        assert!(number(row, "/over_dead_reckoning/median") > 0.0);
        assert!(row["over_dead_reckoning_ns"]["median"].is_number(), "{row}");
    }
}

#[test]
fn what_is_not_to_be_believed_is_printed_and_fails() {
    if !cfg!(debug_assertions) {
        skipped("a release build may be believed");
        return;
    }
    let ended = sim_server(&["bench", "noise", "--seconds", "0.1", "--json"]).expect(1);
    let report = ended.json();
    assert_eq!(report["noise"]["verdict"], "not-to-be-believed");
    ended.says("--accept-noise");
    sim_server(&["bench", "noise", "--seconds", "0.1", "--accept-noise"]).expect(0);
}

#[test]
fn what_cannot_be_measured_is_wrong_usage() {
    for (args, said) in [
        (["--clients", "0"], "--clients"),
        (["--clients", "17"], "--clients"),
        (["--repeat", "0"], "--repeat"),
        (["--ticks", "5"], "--ticks"),
    ] {
        sim_server(&["bench", "latency", args[0], args[1]]).expect(2).says(said);
    }
    sim_server(&["bench", "latency", "--pin", "100000"]).expect(1).says("core 100000");
}

/// The domains that belong to benches of this process.
fn traces_of(pid: u32) -> Vec<String> {
    let mine = |run: &RunName| {
        run.as_str().starts_with("bench-") && Domain::find(run).is_ok_and(|d| d.server_pid() == pid)
    };
    let runs = Domain::list().unwrap().into_iter().map(|(run, _)| run);
    runs.filter(mine).map(|run| run.to_string()).collect()
}

#[test]
fn a_bench_that_is_stopped_leaves_nothing_behind() {
    let long = ["bench", "latency", "--quiet", "--ticks", "100000000", "--clients", "2"];
    let bench = Process::start("sim-server", &long);
    let pid = bench.pid();
    let mut runs = Vec::new();
    until("the bench is under way", || {
        runs = traces_of(pid);
        !runs.is_empty() && participants_started(pid)
    });
    bench.signal(Signal::INT);
    bench.wait().expect(3).says("stopped");
    for run in runs {
        nothing_left(&RunName::new(&run).unwrap());
    }
}

fn participants_started(pid: u32) -> bool {
    let path = format!("/proc/{pid}/task/{pid}/children");
    fs::read_to_string(path).is_ok_and(|children| !children.trim().is_empty())
}

#[test]
fn a_start_is_measured_to_its_first_frame() {
    let args = ["bench", "start", "--repeat", "2", "--json", "--accept-noise"];
    let results = &sim_server(&args).expect(0).json()["results"];
    let (first, end, server) = (&results["rows"][0], &results["rows"][1], &results["rows"][2]);
    assert_eq!(number(first, "/count"), 2.0);
    assert!(0.0 < number(first, "/p50_ms") && number(first, "/p50_ms") < number(end, "/max_ms"));
    assert!(number(server, "/peak_resident_mb") > 1.0);
}

/// Processor time, not time: a machine that is busy with others makes it less.
#[test]
fn who_waits_leaves_the_processor_alone() {
    let args = ["bench", "idle", "--seconds", "2", "--json", "--accept-noise"];
    let report = sim_server(&args).expect(0).json();
    let rows = report["results"]["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2 * 4);
    for row in rows {
        assert!(number(row, "/core_percent") < 20.0, "{row}");
    }
    // The measure is one: a process that does not wait uses its core.
    let (before, mut x) = (Usage::own().unwrap(), 1u64);
    while (Usage::own().unwrap() - before).cpu_ns < 20_000_000 {
        x = std::hint::black_box(x.wrapping_mul(3));
    }
}
