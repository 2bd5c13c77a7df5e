//! Logs with a flipped bit, and logs that end too early.

use rusty_contract::log::ReadEntry;
use rusty_tests::*;

use super::{Run, verb};

#[test]
fn one_flipped_bit_of_a_range_is_named_with_tick_beam_values_and_bits() {
    let run = Run::of("flip", &["--ticks", "200"]);
    let tick = verb("info", &[&run.log()], &["--tick", "95", "--json"]).expect(0).json();
    let range_m = number(&tick, "ranges/17");
    let mut bytes = run.bytes();
    let places: Vec<usize> = bytes
        .windows(8)
        .enumerate()
        .filter(|(_, window)| *window == range_m.to_le_bytes())
        .map(|(at, _)| at)
        .collect();
    assert_eq!(places.len(), 1, "{range_m} stands at {places:?}");
    bytes[places[0]] ^= 1;
    let flipped_m = f64::from_bits(range_m.to_bits() ^ 1);
    let copy = run.write("flipped.log", &bytes);

    let verify = verb("verify", &[&copy], &[]).expect(4).stdout;
    let diff = verb("diff", &[&run.log(), &copy], &[]).expect(4).stdout;
    for said in [verify, diff] {
        assert!(said.contains("tick 95"), "{said}");
        assert!(said.contains("(beam 17)"), "{said}");
        for value in [range_m, flipped_m] {
            let shown = format!("{value:?} (bits {:016x})", value.to_bits());
            assert!(said.contains(&shown), "{shown} is not in: {said}");
        }
    }
    let info = verb("info", &[&copy], &["--json"]).expect(3).json();
    assert_eq!((&info["complete"], &info["damaged_records"]), (&false.into(), &1.into()));
    // Played, the flipped frame gives another digest, and that shows.
    let report = replay(&copy, &run.folder.at("again"), &["--without", "score"]);
    let report = report.expect(4).json();
    assert_ne!(text(&report, "digest"), run.digest());
}

#[test]
fn a_bit_flipped_anywhere_makes_nothing_panic_and_never_passes() {
    let run = Run::of("flips", &["--ticks", "300", "--without", "score"]);
    let bytes = run.bytes();
    for at in (0..bytes.len()).step_by(997) {
        let mut flipped = bytes.clone();
        flipped[at] ^= 1 << (at % 8);
        let copy = run.write("flipped.log", &flipped);
        let log = run.log();
        for (what, ended) in [
            ("verify", verb("verify", &[&copy], &[])),
            ("info", verb("info", &[&copy], &[])),
            ("diff", verb("diff", &[&log, &copy], &[])),
        ] {
            let known = (1..=4).contains(&ended.code.unwrap_or(-1));
            assert!(known && !ended.stderr.contains("panicked"), "{what}, byte {at}: {ended:#?}");
        }
    }
}

/// Where a record's number stands: behind its length, checksum and kind.
fn tick_byte(bytes: &[u8], entry: &ReadEntry) -> usize {
    let mut at = entry.at_byte as usize;
    while bytes[at] & 0x80 != 0 {
        at += 1;
    }
    at + 1 + 4 + 1
}

#[test]
fn a_damaged_log_that_is_played_blames_nobody() {
    let run = Run::of("blame", &["--ticks", "200", "--without", "score"]);
    let (bytes, ticks) = (run.bytes(), Log::read(&run.log()).entries);
    let number = tick_byte(&bytes, &ticks[100]);
    assert_eq!(bytes[number], 100);
    // From the second tick on: a log without a complete tick is not played.
    let second = ticks[1].at_byte as usize;
    let places = (second..bytes.len()).step_by(9973).map(|at| (at, at % 8));
    for (at, bit) in places.chain([(number, 0), (number, 5)]) {
        let mut flipped = bytes.clone();
        flipped[at] ^= 1 << bit;
        let copy = run.write("flipped.log", &flipped);
        let out = run.folder.at("played");
        let ended = replay(&copy, &out, &["--force"]);
        let known = matches!(ended.code, Some(3 | 4));
        assert!(known && !ended.stderr.contains("panicked"), "byte {at}: {ended:#?}");
        assert_eq!(ended.json()["losses"], json!([]), "byte {at}: {ended:#?}");
    }
}

/// A short log of small scans whose last tick has one, and where its last two
/// records and its trailer begin.
fn short_log() -> (Run, Vec<usize>) {
    let args = ["--ticks", "201", "--set", "lidar.beams=20", "--without", "score"];
    let run = Run::of("cut", &args);
    let log = Log::read(&run.log());
    assert!(log.is_complete());
    let ticks = log.entries;
    assert_eq!(ticks.len(), 201);
    let bytes = run.bytes();
    let mut starts: Vec<usize> = ticks[199..].iter().map(|t| t.at_byte as usize).collect();
    // A record is its length in 7-bit groups, four bytes of checksum, its body.
    let (mut at, mut length, mut shift) = (starts[1], 0, 0);
    loop {
        length |= usize::from(bytes[at] & 0x7F) << shift;
        (at, shift) = (at + 1, shift + 7);
        if bytes[at - 1] & 0x80 == 0 {
            break;
        }
    }
    starts.push(at + 4 + length);
    (run, starts)
}

#[test]
fn everyone_works_on_the_complete_ticks_of_a_cut_log_and_says_so() {
    let (run, starts) = short_log();
    let bytes = run.bytes();
    let out = run.folder.at("cut");
    let out_arg = arg(&out);
    for (at, complete) in [
        (starts[0], 199),
        (starts[1] - 1, 199),
        (starts[1] + 3, 200),
        (starts[2], 201),
        (bytes.len() - 1, 201),
    ] {
        let copy = run.write("cut.log", &bytes[..at]);
        let info = about("info", &copy, &["--json"]).expect(3).json();
        assert_eq!((&info["ticks"], &info["complete"]), (&complete.into(), &false.into()), "{at}");
        let said = text(&info, "cut");
        assert!(said.contains(&format!("cut after {complete} complete ticks")), "{said}");
        let verdict = about("verify", &copy, &["--json"]).expect(3).json();
        let ticks = (&verdict["ticks"], &verdict["bit_exact"], &verdict["complete"]);
        assert_eq!(ticks, (&complete.into(), &true.into(), &false.into()), "{at}");
        let report = replay(&copy, &out, &["--without", "logger", "--force"]).expect(3).json();
        let comparison = &report["comparison"];
        assert_eq!((&report["ticks"], &comparison["cut"]), (&complete.into(), &true.into()));
        assert_eq!(comparison["compared"], complete);
        assert_eq!(comparison["equal"], complete);

        let log = arg(&copy);
        let with_out = ["--log", log, "--out", out_arg];
        let said = execute("dead-reckoning", &with_out[..2]).expect(3);
        assert_eq!(said.stdout.lines().count(), complete + 1);
        said.says(&format!("ends after {complete} ticks"));
        let with_out = [&with_out[..], &["--force"]].concat();
        execute("score", &with_out).expect(3);
        let score = json_file(&out.join("score.json"));
        assert_eq!(score["scores"][0]["scored_ticks"], complete);
        // A log written from a cut one holds the same ticks and pretends no end.
        execute("logger", &with_out).expect(3);
        let end = *starts.iter().rfind(|start| **start <= at).unwrap();
        assert!(fs::read(out.join("run.log")).unwrap() == bytes[..end], "cut at {at}");
    }
}
