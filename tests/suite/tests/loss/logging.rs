//! The logger writes behind its run: what it has taken reaches the file soon and
//! whole, or it says why not.

use std::os::unix::fs::symlink;

use rusty_tests::*;

/// Writes `log` again into `out`, by a shell that does `before` first.
fn logger_again(before: &str, log: &str, out: &str) -> Ended {
    let script = format!("{before} exec \"$0\" \"$@\"");
    Process::spawn(&mut shell(&script, "logger", &["--log", log, "--out", out])).wait()
}

/// What everyone is told who cannot write a log.
fn says_all(ended: &Ended, what: &str) {
    for part in ["run.log: ", what, " ticks had been taken", "--out"] {
        ended.says(part);
    }
}

#[test]
fn a_log_written_again_has_the_same_bytes_and_one_that_cannot_be_says_why() {
    let (_out, log) = logged("again", &["--ticks", "600"]);
    let (bytes, log) = (fs::read(&log).unwrap(), arg(&log));

    let copy = folder();
    logger_again("", log, arg(copy.path())).expect(0);
    assert!(fs::read(copy.at("run.log")).unwrap() == bytes);

    let full = folder();
    symlink("/dev/full", full.at("run.log")).unwrap();
    let ended = logger_again("", log, arg(full.path())).expect(1);
    says_all(&ended, "No space left on device");

    // A file may grow to 100 blocks of 512 bytes: in the middle of the run.
    let short = folder();
    let ended = logger_again("ulimit -f 100;", log, arg(short.path())).expect(1);
    says_all(&ended, "File too large");
    let cut = fs::read(short.at("run.log")).unwrap();
    assert!(cut.len() < bytes.len() && bytes.starts_with(&cut), "{} bytes", cut.len());
    let info = about("info", &short.at("run.log"), &["--json"]).expect(3).json();
    assert!(info["ticks"].as_u64().unwrap() > 0, "{info}");
}

/// A launch that stands still after `ticks` ticks.
fn standing(tag: &str, ticks: u64) -> Live {
    let live = Live::start("launch", tag, &[&["--ticks", "300", "--paused"]]);
    until("it has stepped", || live.control(&["step", &ticks.to_string()]));
    live
}

#[test]
fn what_was_taken_reaches_the_file_although_the_run_stands_still() {
    let live = standing("still", 7);
    // The answers to a tick are written when the one after it is there.
    until("the log has them", || written(&live.log()) >= 6);
    assert!(live.control(&["resume"]));
    live.ends_with(0).verifies(0);
}

#[test]
fn a_log_that_somebody_else_cuts_does_not_pass_for_whole() {
    let live = standing("cut", 100);
    live.until_the_log_has_ticks();
    let file = fs::File::options().write(true).open(live.log()).unwrap();
    file.set_len(10).unwrap();
    assert!(live.control(&["resume"]));
    let after = live.ends_with(3);
    let remarks = after.report["remarks"].to_string();
    assert!(remarks.contains("bytes where") && remarks.contains("were written"), "{remarks}");
}

#[test]
fn a_measurement_reads_what_it_wrote_and_leaves_nothing() {
    let place = folder();
    let path = arg(place.path());
    let measure = |more: &[&str]| {
        let args = [&["measure", path, "--ticks", "300", "--json"], more].concat();
        execute("logger", &args).expect(0).json()
    };
    let with_scans = measure(&["--sync"]);
    // 1080 ranges of 8 bytes, and little else.
    let per_tick = number(&with_scans, "bytes_per_tick");
    assert!((8640.0..8850.0).contains(&per_tick), "{with_scans}");
    assert_eq!(with_scans["digest"], measure(&[])["digest"]);
    assert_ne!(with_scans["digest"], measure(&["--beams", "0"])["digest"]);
    for rate in ["log_mb_s", "plain_mb_s", "encode_mb_s", "log_per_plain"] {
        assert!(with_scans[rate].as_f64().unwrap() > 0.0, "{rate}: {with_scans}");
    }
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 0);
    let args = ["measure", path, "--beams", "5000"];
    execute("logger", &args).expect(1).says("--beams 5000: a frame has at most 1080");
}

#[test]
fn the_bench_of_logs_says_what_was_measured() {
    let place = folder();
    let path = arg(place.path());
    let bench = |beams: &str| {
        let few = ["--ticks", "200", "--repeat", "2", "--accept-noise", "--json", "--quiet"];
        sim_server(&[&["bench", "log", path, "--beams", beams], &few[..]].concat())
    };
    let report = bench("0,1080").expect(0).json();
    let rows = list(&report["results"], "rows");
    assert_eq!(rows.len(), 2);
    for row in rows {
        assert!(number(row, "log_over_plain/median") > 0.0, "{row}");
        assert_eq!(text(row, "digest").len(), 32);
    }
    assert!(rows[0]["bytes_per_tick"].as_f64() < rows[1]["bytes_per_tick"].as_f64());
    assert!(bench("5000").expect(1).stderr.contains("--beams 5000"));
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 0);
}
