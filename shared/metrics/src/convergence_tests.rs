//! Holds by hand: found, cut, interrupted, lost and found again.

use super::*;
use rusty_geometry::SE2;

const DT_S: f64 = 0.02;

/// What a tick says of the estimator: how far off it is, m; nothing given; no
/// truth to compare with.
#[derive(Clone, Copy)]
enum At {
    Off(f64),
    Silent,
    Unseen,
}
use At::{Off, Silent, Unseen};

const NEAR: At = Off(0.1);
const FAR: At = Off(3.0);

fn run(within: Within, kidnapped_at: &[u64], ticks: impl IntoIterator<Item = At>) -> Convergence {
    let mut search = Search::new(within, kidnapped_at, Some(0.0));
    for (tick, at) in (0u64..).zip(ticks) {
        search.begin(tick, (tick + 1) as f64 * DT_S);
        match at {
            Off(x_m) => search.push(&Scored {
                tick: tick as usize,
                truth: SE2::identity(),
                estimate: SE2::new(x_m, 0.0, 0.0),
            }),
            Silent => search.silent(),
            Unseen => {}
        }
    }
    search.convergence().unwrap()
}

fn rows(parts: &[(At, usize)]) -> Vec<At> {
    parts.iter().flat_map(|&(at, count)| std::iter::repeat_n(at, count)).collect()
}

/// Times by which ticks end, s.
fn ends(tick: u64) -> Option<f64> {
    Some((tick + 1) as f64 * DT_S)
}

fn near(found: Option<f64>, expected: f64) {
    let found = found.unwrap();
    assert!((found - expected).abs() < 1e-12, "{found} is not {expected}");
}

#[test]
fn the_first_tick_of_the_first_hold_counts_and_a_second_is_fifty_ticks_on() {
    let plain = Within::default();
    // 51 ticks have a second between the first and the last of them.
    for (held, found) in [(50, None), (51, ends(10)), (52, ends(10))] {
        let found_at = run(plain, &[], rows(&[(FAR, 10), (NEAR, held), (FAR, 5)]));
        assert_eq!(found_at.after_s, found, "{held} ticks");
    }
    // Cut by the end of the run: no hold.
    let cut = run(plain, &[], rows(&[(FAR, 10), (NEAR, 50)]));
    assert_eq!((cut.after_s, cut.position_rmse_m, cut.heading_rmse_rad), (None, None, None));
    assert_eq!(run(plain, &[], rows(&[(NEAR, 51)])).after_s, ends(0));
    // A row that was interrupted begins again.
    let late = run(plain, &[], rows(&[(NEAR, 40), (FAR, 1), (NEAR, 60)]));
    assert_eq!(late.after_s, ends(41));
    near(late.position_rmse_m, 0.1);
}

#[test]
fn the_threshold_itself_is_within_and_a_hold_of_no_time_is_one_tick() {
    let within = Within { position_m: 0.25, hold_s: 0.0, ..Within::default() };
    assert_eq!(run(within, &[], [FAR, Off(0.25)]).after_s, ends(1));
    assert_eq!(run(within, &[], [FAR, Off(0.2500001)]).after_s, None);
    let mut search = Search::new(within, &[], Some(0.0));
    search.begin(0, DT_S);
    // Turned by a little more than 10°, beyond ±π or not.
    let half = core::f64::consts::PI;
    let truth = SE2::new(0.0, 0.0, half - 0.01);
    let estimate = SE2::new(0.0, 0.0, -half + 10.1f64.to_radians() - 0.01);
    search.push(&Scored { tick: 0, truth, estimate });
    assert_eq!(search.convergence().unwrap().after_s, None);
    let estimate = SE2::new(0.0, 0.0, -half + 9.9f64.to_radians() - 0.01);
    search.push(&Scored { tick: 0, truth, estimate });
    assert_eq!(search.convergence().unwrap().after_s, Some(DT_S));
}

#[test]
fn what_cannot_be_compared_is_passed_over_but_long_silence_is_not() {
    let plain = Within::default();
    // A truth at every third tick only, and an answer at every other of those.
    let sparse = (0..200).map(|k| match k % 6 {
        0 => NEAR,
        3 => Silent,
        _ => Unseen,
    });
    assert_eq!(run(plain, &[], sparse).after_s, ends(0));
    // No truth for a minute: nothing speaks against it.
    let blind = rows(&[(NEAR, 1), (Unseen, 3000), (NEAR, 1)]);
    assert_eq!(run(plain, &[], blind).after_s, ends(0));
    // Silent for a second is let pass, for longer is not.
    let pause = |silent: usize| rows(&[(NEAR, 10), (Silent, silent), (NEAR, 30)]);
    assert_eq!(run(plain, &[], pause(49)).after_s, ends(0));
    assert_eq!(run(plain, &[], pause(50)).after_s, ends(0));
    assert_eq!(run(plain, &[], pause(51)).after_s, None);
    // Lost for good after the hold: it had been found.
    assert_eq!(run(plain, &[], rows(&[(NEAR, 60), (Silent, 500)])).after_s, ends(0));
}

#[test]
fn a_kidnapping_ends_it_and_recovery_is_timed_from_the_start_of_its_tick() {
    let ticks = rows(&[(NEAR, 100), (FAR, 30), (NEAR, 100)]);
    let found = run(Within::default(), &[100], ticks.clone());
    assert_eq!(found.after_s, ends(0));
    assert_eq!(found.recoveries.len(), 1);
    assert_eq!(found.recoveries[0].kidnapped_at_tick, 100);
    near(found.recoveries[0].after_s, 31.0 * DT_S);
    near(found.position_rmse_m, 0.1); // without the thirty
    // Without a kidnapping they are its own errors.
    let astray = run(Within::default(), &[], ticks);
    assert!(astray.recoveries.is_empty());
    near(astray.position_rmse_m, ((200.0 * 0.01 + 30.0 * 9.0) / 230.0_f64).sqrt());
}

#[test]
fn who_is_carried_nowhere_has_recovered_at_the_end_of_that_tick() {
    let found = run(Within::default(), &[70], rows(&[(NEAR, 200)]));
    near(found.recoveries[0].after_s, DT_S);
}

#[test]
fn a_kidnapping_cuts_a_row_and_the_next_one_ends_the_search_for_the_last() {
    // Never found before the first one; found again between the second and the
    // third alone; the fourth is beyond the end of the run.
    let ticks = rows(&[(NEAR, 40), (NEAR, 40), (FAR, 20), (NEAR, 60), (FAR, 10)]);
    let found = run(Within::default(), &[40, 80, 160, 400], ticks);
    let after: Vec<Option<f64>> = found.recoveries.iter().map(|r| r.after_s).collect();
    assert_eq!((after.len(), after[0], after[2]), (3, None, None));
    near(after[1], 21.0 * DT_S);
    assert_eq!(found.after_s, ends(100));
    near(found.position_rmse_m, 0.1);
}

#[test]
fn stamps_that_are_the_time_of_day_count_from_the_first() {
    let mut search = Search::new(Within::default(), &[], None);
    for tick in 0..60 {
        search.begin(tick, 976_052_857.38 + tick as f64 * 0.1);
        let x_m = if tick < 20 { 3.0 } else { 0.1 };
        let (truth, estimate) = (SE2::identity(), SE2::new(x_m, 0.0, 0.0));
        search.push(&Scored { tick: tick as usize, truth, estimate });
    }
    let after_s = search.convergence().unwrap().after_s.unwrap();
    assert!((after_s - 2.0).abs() < 1e-6, "{after_s}");
}

#[test]
fn without_a_scored_tick_there_is_nothing_to_say() {
    let mut search = Search::new(Within::default(), &[0], None);
    search.begin(0, DT_S);
    search.silent();
    assert_eq!(search.convergence(), None);
}
