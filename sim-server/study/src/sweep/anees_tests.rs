//! Covariances that are right, four times too small, four times too large.

use rusty_geometry::SE2;
use rusty_sim::noise::TickNoise;

use super::super::client_figures::ClientFigures;
use super::super::fixtures::row;
use super::super::{Cell, Sample};
use super::*;

/// Ticks along the way of one run.
const TICKS: u64 = 60;

/// χ² with three degrees of freedom, drawn from a seed.
fn chi_square_3(noise: &mut TickNoise, tick: u64) -> f64 {
    let [a, b] = noise.normals::<2>(2 * tick);
    let [c, _] = noise.normals::<2>(2 * tick + 1);
    a * a + b * b + c * c
}

/// A run whose squared errors are `factor` times what its covariances say.
fn run(seed: u64, factor: f64) -> (Row, Track) {
    let mut noise = TickNoise::slip(seed);
    let nees: Vec<f64> = (0..TICKS).map(|t| factor * chi_square_3(&mut noise, t)).collect();
    let clients = ClientFigures {
        nees_samples: TICKS,
        nees_mean: Moments::of(&nees).mean,
        nees_last: nees[nees.len() - 1],
        nis_samples: TICKS,
        nis_sum: nees.iter().sum(),
        nis_degrees: POSE * TICKS as f64,
        ..ClientFigures::of(None)
    };
    let here = SE2::identity();
    let sample = |(tick, nees): (usize, &f64)| Sample {
        time_s: 0.1 * (tick + 1) as f64,
        distance_m: 0.0,
        truth: here,
        estimate: here,
        nees: Some(*nees),
    };
    let samples = nees.iter().enumerate().map(sample).collect();
    let row = Row { clients: Some(clients), ..row(0, seed, "filter") };
    (row, Track { cell: 0, seed, estimator: "filter".to_owned(), samples })
}

fn swept(seeds: u64, factor: f64) -> Swept {
    let (rows, tracks) = (0..seeds).map(|seed| run(seed, factor)).unzip();
    let config = super::super::fixtures::straight_leg();
    let cell = Cell { parameters: Vec::new().into(), config };
    Swept { cells: vec![cell], rows, tracks }
}

#[test]
fn right_too_small_and_too_large_covariances_are_told_apart() {
    for (factor, verdict) in
        [(1.0, Verdict::Consistent), (4.0, Verdict::Overconfident), (0.25, Verdict::Conservative)]
    {
        let found = anees(&swept(40, factor)).swap_remove(0);
        let last = found.last.unwrap();
        assert_eq!((found.runs, found.without, last.n), (40, 0, 40));
        assert_eq!(last.verdict, verdict, "{last:?}");
        // χ²₁₂₀ over 40: from 91.573 to 152.211.
        assert!((last.interval[0] - 91.573 / 40.0).abs() < 1e-3, "{last:?}");
        assert!((last.interval[1] - 152.211 / 40.0).abs() < 1e-3, "{last:?}");
        assert_eq!(found.along.len(), 60);
        assert!((found.along[0].time_s, found.along[59].time_s) == (0.1, 6.0));
        let few = if factor == 1.0 { 0.88..1.0 } else { 0.0..0.01 };
        assert!(few.contains(&found.share_inside), "{}", found.share_inside);
        assert!((found.time_mean / (POSE * factor) - 1.0).abs() < 0.08, "{}", found.time_mean);
        assert_eq!(found.time_verdict, Some(verdict), "{found:?}");
        let half = found.time_mean_half_width / factor;
        assert!((0.05..0.25).contains(&half), "{half}");
        assert_eq!(found.nis.unwrap().verdict, verdict);
        let text = AneesText(&[found]).to_string();
        assert!(text.contains(verdict.word()) && text.contains("2400 innovations"), "{text}");
    }
}

/// How many of 400 groups of 8 seeds, each with one NEES, get another verdict than
/// consistent.
fn wrong(verdict: impl Fn(&[f64]) -> Verdict) -> usize {
    let group = |group: u64| -> Vec<f64> {
        let value = |k: u64| chi_square_3(&mut TickNoise::slip(8 * group + k), 0);
        (0..8).map(value).collect()
    };
    (0..400).filter(|k| verdict(&group(*k)) != Verdict::Consistent).count()
}

#[test]
fn the_interval_holds_what_it_promises() {
    // Once in twenty the verdict is wrong: 20 ± 4.4.
    let wrong = wrong(|values| Average::of(0.1, values).verdict);
    assert!((8..34).contains(&wrong), "{wrong}");
}

#[test]
fn errors_that_never_change_are_seldom_called_inconsistent_over_time() {
    // 12 % by docs/metrics.md: 47 ± 6.4.
    let wrong = wrong(|values| {
        let means = Moments::of(values);
        over_time(&means, half_width(&means, LEVEL))
    });
    assert!((28..66).contains(&wrong), "{wrong}");
}

#[test]
fn one_run_that_is_lost_does_not_hide_in_its_own_spread() {
    let mut all = swept(4, 1.0);
    all.rows[2].clients.as_mut().unwrap().nees_mean = 1e7;
    let found = anees(&all).swap_remove(0);
    assert!(found.time_mean_half_width > found.time_mean, "{found:?}");
    assert_eq!(found.time_verdict, Some(Verdict::Overconfident), "{found:?}");
    // Runs that do not scatter more than one NEES are left to their t interval.
    all.rows[2].clients.as_mut().unwrap().nees_mean = 3.0 + 2.0;
    assert_eq!(anees(&all)[0].time_verdict, Some(Verdict::Consistent));
}

#[test]
fn who_reports_no_covariance_is_unscored() {
    let mut all = swept(5, 1.0);
    for row in &mut all.rows[..2] {
        row.clients = Some(ClientFigures::of(None));
    }
    let some = anees(&all).swap_remove(0);
    assert_eq!((some.runs, some.without), (3, 2));
    for row in &mut all.rows {
        row.clients = Some(ClientFigures::of(None));
    }
    all.tracks.clear();
    let none = anees(&all).swap_remove(0);
    assert!(none.last.is_none() && none.share_inside.is_nan() && none.nis.is_none());
    assert!(AneesText(&[none]).to_string().contains("unscored"));
    // Made inside, no participant is asked.
    all.rows.iter_mut().for_each(|row| row.clients = None);
    assert!(anees(&all).is_empty());
}

#[test]
fn runs_that_did_not_end_together_have_no_time_of_their_last_tick() {
    let mut all = swept(3, 1.0);
    assert_eq!(anees(&all)[0].last.unwrap().time_s, 30.0);
    all.rows[1].time_s = 12.0;
    assert!(anees(&all)[0].last.unwrap().time_s.is_nan());
}
