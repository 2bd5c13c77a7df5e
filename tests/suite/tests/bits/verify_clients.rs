//! `verify --clients`: a log's estimators and driver run again, and every
//! answer compared. What differs is named with tick, participant, field, both
//! values and their bits.

use rusty_tests::*;

const TICKS: &str = "60";

fn verify(log: &Path, args: &[&str]) -> Ended {
    about("verify", log, &[&["--clients"], args].concat())
}

/// A run of the probe with covariances: its log, in a folder that is kept.
fn probed() -> (Folder, PathBuf) {
    let place = folder();
    let add = probe("probe", "covariance");
    let args = ["--ticks", TICKS, "--without", "score", "--add", &add];
    let report = launch("probed", &place.at("run"), &args);
    let log = log_of(&report);
    (place, log)
}

fn show(value: f64) -> String {
    format!("{value:?} (bits {:016x})", value.to_bits())
}

#[test]
fn answers_that_come_again_are_counted_and_nothing_is_written() {
    let place = folder();
    let out = place.at("run");
    let report = launch("driven", &out, &["driver", "--ticks", TICKS, "--without", "score"]);
    let log = log_of(&report);
    let files = || fs::read_dir(&out).unwrap().count();
    let before = files();
    let temporary = folder();
    let mut command = Command::new(binary("sim-server"));
    command.args(["verify", "--clients"]).arg(&log).env("TMPDIR", temporary.path());
    let ended = Process::spawn(command.current_dir(&out)).wait().expect(0);
    assert_eq!(fs::read_dir(temporary.path()).unwrap().count(), 0);
    let (header, _) = load(&log);
    let answers: Vec<String> =
        header.answering().map(|p| format!(", {TICKS} answers of {}", p.name)).collect();
    assert!(header.answering().any(|p| p.role == rusty_contract::Role::Driver));
    let digest = text(&report, "digest");
    let line = format!("bit-exact: {TICKS} ticks, digest {digest}{}\n", answers.join(""));
    assert_eq!(ended.stdout, line);
    assert_eq!(files(), before);

    // The same of a log that was cut: what it has is compared.
    let bytes = fs::read(&log).unwrap();
    let cut = place.at("cut.log");
    fs::write(&cut, &bytes[..bytes.len() - 60]).unwrap();
    let verdict = verify(&cut, &["--json"]).expect(3).json();
    assert_eq!((&verdict["bit_exact"], &verdict["complete"]), (&true.into(), &false.into()));
    let someone = &verdict["clients"]["participants"][0];
    assert_eq!(someone["compared"], verdict["ticks"]);
    assert_eq!(someone["equal"], verdict["ticks"]);
}

#[test]
fn one_bit_of_an_answer_is_named_and_the_earlier_difference_comes_first() {
    let (place, log) = probed();
    let (header, records) = load(&log);
    let slot = header.answering().position(|p| p.name == "probe").unwrap();
    let copy = place.at("flipped.log");
    let mut flipped = records.clone();
    let Reply::Estimate(estimate) = &mut flipped[31].replies[slot] else { panic!() };
    let variance = &mut estimate.covariance.as_mut().unwrap()[4];
    let before = *variance;
    *variance = f64::from_bits(before.to_bits() ^ 1);
    let after = *variance;
    write_log(&copy, &header, &flipped);
    // Nothing but the client itself can tell.
    sim_server(&["verify", arg(&copy)]).expect(0);
    let (recorded, again) = (show(after), show(before));
    let line = format!(
        "not bit-exact: tick 31, probe, covariance[1][1]: the log has {recorded}, expected was {again}\n"
    );
    assert_eq!(verify(&copy, &[]).expect(4).stdout, line);
    let verdict = verify(&copy, &["--json"]).expect(4).json();
    let first = &verdict["first_difference"];
    assert_eq!((&first["tick"], text(first, "participant")), (&31.into(), "probe"));
    assert_eq!([text(first, "a"), text(first, "b")], [recorded, again]);

    // A replay says the same of it.
    let replayed = replay(&copy, &place.at("named"), &[]);
    let found = &replayed.expect(4).json()["comparison"]["first_difference"];
    assert_eq!((&found["tick"], text(found, "name")), (&31.into(), "probe"));
    let values = ["field", "recorded", "replayed"].map(|key| text(found, key));
    assert_eq!(values, ["covariance[1][1]", &show(after), &show(before)]);

    // A frame that is wrong, before and behind it.
    for (tick, named) in [(35, "tick 31, probe, cov"), (30, "tick 30, ranges_m[7] (beam 7): ")] {
        let mut both = flipped.clone();
        let range = &mut both[tick].ranges_m.as_mut().unwrap()[7];
        *range = f64::from_bits(range.to_bits() ^ 1);
        write_log(&copy, &header, &both);
        let said = verify(&copy, &[]).expect(4).stdout;
        assert!(said.starts_with(&format!("not bit-exact: {named}")), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
}

#[test]
fn a_program_that_changed_is_named_with_the_first_answer_that_is_another() {
    let (place, log) = probed();
    let (mut header, records) = load(&log);
    let copy = place.at("changed.log");
    let probe = header.roster.iter().position(|p| p.name == "probe").unwrap();
    for (mode, expected) in [("abstain", "abstain\n"), ("exit", "missing\n"), ("", "")] {
        header.roster[probe].command = vec![binary("probe-client").display().to_string()];
        header.roster[probe].command.extend(["--mode".to_owned(), mode.to_owned()]);
        write_log(&copy, &header, &records);
        let ended = verify(&copy, &[]).expect(4);
        // Up to tick 10 only the covariance is missing; so mode "" differs at once.
        let start = "not bit-exact: tick 0, probe, kind: the log has estimate x_m ";
        assert!(ended.stdout.starts_with(start), "{ended:?}");
        ended.prints("covariance[2][2] 0.03, expected was estimate x_m");
        // From a log without covariances, the mode itself is what is seen.
        if mode.is_empty() {
            continue;
        }
        let mut plain = records.clone();
        for reply in plain.iter_mut().filter_map(|r| r.replies.get_mut(probe)) {
            let Reply::Estimate(estimate) = reply else { panic!() };
            estimate.covariance = None;
        }
        write_log(&copy, &header, &plain);
        let said = verify(&copy, &[]).expect(4).stdout;
        let start = "not bit-exact: tick 10, probe, kind: the log has estimate x_m ";
        assert!(said.starts_with(start) && said.ends_with(expected), "{said}");
    }
}

#[test]
fn what_a_lost_participant_did_not_answer_is_no_difference() {
    let (place, log) = probed();
    let (header, mut records) = load(&log);
    let copy = place.at("lost.log");
    for record in &mut records[40..] {
        record.replies.fill(Reply::Missing);
    }
    write_log(&copy, &header, &records);
    let ended = verify(&copy, &[]).expect(0);
    assert!(
        ended.stdout.ends_with(", 40 answers of dead-reckoning, 40 answers of probe\n"),
        "{ended:?}"
    );
    ended.says("probe: the log lacks its answers to 20 ticks");
}

#[test]
fn a_program_that_cannot_be_run_again_is_no_difference_but_an_error() {
    let (place, log) = probed();
    let (mut header, records) = load(&log);
    let copy = place.at("gone.log");
    let probe = header.roster.iter().position(|p| p.name == "probe").unwrap();
    for (command, code, words) in [
        (&["no-such-filter"][..], 1, "\"no-such-filter\" is neither beside"),
        (&["/no/such/filter"], 1, "cannot start /no/such/filter: No such file"),
        (&["dead-reckoning", "--no-such-flag"], 1, "\"probe\" could not be run again: "),
        (&[], 2, "participant \"probe\", command = []: is empty: it was started by hand"),
    ] {
        header.roster[probe].command = command.iter().map(|&word| word.to_owned()).collect();
        write_log(&copy, &header, &records);
        let ended = verify(&copy, &[]).expect(code);
        ended.says(words);
        assert_eq!(ended.stdout, "");
    }
}
