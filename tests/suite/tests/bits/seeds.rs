//! Seeds that cannot be guessed: drawn with `--seed random`, printed so that the
//! run can be repeated, and recommended where a small seed would give the truth.

use rusty_contract::log::LogReader;
use rusty_tests::*;

const TICKS: [&str; 2] = ["--ticks", "30"];

/// How many lines of stderr name the remedy.
fn warnings(ended: &Ended) -> usize {
    ended.stderr.lines().filter(|line| line.contains("--seed random")).count()
}

#[test]
fn a_random_seed_is_printed_and_repeats_the_run() {
    let place = folder();
    let launch = |name: &str, seed: &str| {
        let out = place.at(name);
        let ended =
            run_to("seed", &out, &[&["launch", "--quiet"], &TICKS[..], &["--seed", seed]].concat())
                .expect(0);
        let report = ended.json();
        let drawn = report["seed"].as_u64().unwrap();
        ended.says(&format!("seed {drawn} · "));
        let log = log_of(&report);
        assert_eq!(LogReader::open(&log).unwrap().header().seed(), Some(drawn));
        (drawn, text(&report, "digest").to_owned(), log)
    };
    let (a, b) = (launch("a", "random"), launch("b", "random"));
    assert!(a.0 != b.0 && a.0 >= 1 << 40 && b.0 >= 1 << 40, "{} and {}", a.0, b.0);
    assert_ne!(a.1, b.1);
    let again = launch("again", &a.0.to_string());
    assert_eq!((a.0, &a.1), (again.0, &again.1));
    let log = arg(&a.2);
    let _ = sim_server(&["verify", log]).expect(0);

    let out = place.at("fork");
    let forked = run_to("seed", &out, &["fork", log, "--at", "10", "--seed", "random"]);
    let forked = forked.expect(0).json();
    let seed = forked["seed"].as_u64().unwrap();
    assert!(seed != a.0 && seed >= 1 << 40, "{seed}");
    let _ = sim_server(&["verify", text(&forked, "log")]).expect(0);
}

#[test]
fn a_small_seed_is_warned_of_where_the_truth_is_withheld() {
    let place = folder();
    let sealed = |name: &str, seed: &str, sandbox: &str| {
        let at = |end: &str| place.at(format!("{name}{end}"));
        let args = ["--seed", seed, "--sandbox", sandbox];
        let made = run_to("seed", &at(""), &[&["launch", "--quiet"], &TICKS[..], &args].concat())
            .expect(0);
        let seal = seal(&log_of(&made.json()), &at(".blind"), &at(".key")).expect(0);
        (warnings(&made), warnings(&seal))
    };
    // 2^40 - 1 and 2^40.
    assert_eq!(sealed("open", "42", "none"), (0, 1));
    assert_eq!(sealed("confined", "1099511627775", "if-possible"), (1, 1));
    assert_eq!(sealed("large", "1099511627776", "if-possible"), (0, 0));
    assert_eq!(sealed("random", "random", "if-possible"), (0, 0));
}
