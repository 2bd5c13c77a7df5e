//! What rows, ratios and verdicts come to.

use super::*;

fn case(contender: Contender, wait: Wait, tick_ns: u64, digest: &str) -> Case {
    let mut case = Case::new(contender, wait, GOAL_CLIENTS);
    for _ in 0..2 {
        let ticks_ns = vec![tick_ns, tick_ns, 10 * tick_ns];
        case.add(Measured { ticks_ns, cpu_ns: Some(6_000), digest: digest.to_owned() });
    }
    case
}

fn settings() -> Settings {
    Settings { ticks: 3, warm_up: 0, repetitions: 2, scans: false }
}

fn results(digest: &str) -> Results {
    let cases = vec![
        case(Contender::Zmq, Wait::Block, 90_000, digest),
        case(Contender::Zmq, Wait::Poll, 30_000, "d"),
        case(Contender::Ours, Wait::Block, 45_000, "d"),
        case(Contender::Ours, Wait::Poll, 2_000, "d"),
        case(Contender::Ours, Wait::Balanced, 3_000, "d"),
    ];
    Results::of(settings(), cases, Vec::new())
}

#[test]
fn a_ratio_is_to_ours_in_the_same_wait_and_to_ours_as_it_comes() {
    let results = results("d");
    let zmq = &results.rows[0];
    assert_eq!((zmq.times_ours_same_wait, zmq.times_ours), (Some(2.0), Some(30.0)));
    assert_eq!(results.rows[1].times_ours_same_wait, Some(15.0));
    assert_eq!((zmq.tick.count, zmq.repetitions), (6, 2));
    assert_eq!(zmq.cpu_ns_per_tick, Some(2_000.0));
    assert_eq!(zmq.ticks_per_s, 1e9 / 360_000.0);
    assert_eq!(results.rows[4].times_ours, Some(1.0));
    let row = &results.report().rows[0];
    assert_eq!(row.name, "zmq, block, 3 clients");
    assert_eq!((row.number("times_ours"), row.number("p50_ns")), (30.0, 90_000.0));
}

#[test]
fn a_goal_says_which_of_its_ratios_meet_it() {
    let results = results("d");
    let [goal] = results.goals.as_slice() else { panic!("{:?}", results.goals) };
    let text = goal.to_string();
    assert!(text.contains("as people use it 30.0× (met)"), "{text}");
    assert!(text.contains("both polling 15.0× (missed)"), "{text}");
    assert!(text.contains("both blocking 2.0× (missed)"), "{text}");
}

#[test]
fn different_runs_show() {
    assert!(results("d").are_the_same_runs());
    assert!(!results("e").are_the_same_runs());
}

#[test]
fn who_failed_or_was_not_measured_has_no_numbers() {
    let mut failed = Case::new(Contender::Zenoh, Wait::Block, 1);
    failed.fail("it broke".to_owned());
    let results = Results::of(settings(), vec![failed], Vec::new());
    assert!(results.has_failures() && results.goals.is_empty());
    let report = results.report();
    assert!(report.to_string().contains("it broke"));
    assert!(report.rows[0].number("p50_ns").is_nan());
    assert_eq!(results.rows[0].times_ours, None);
}
