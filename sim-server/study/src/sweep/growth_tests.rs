//! Spreads whose exponent is known are found with it.

use rusty_geometry::{SE2, trig};
use rusty_sim::noise::TickNoise;

use super::super::fixtures::{reckoned, straight_leg, track};
use super::*;

/// A sample `s` metres along a straight track with these errors.
fn at(s: f64, across_m: f64, heading_rad: f64) -> Sample {
    let truth = SE2::new(s, 0.0, 0.0);
    let estimate = {
        let mut error = SE2::identity().log();
        (error.y, error.z) = (across_m, heading_rad);
        truth.boxplus(&error)
    };
    Sample { time_s: 2.0 * s, distance_m: s, truth, estimate, nees: None }
}

fn power(x: f64, p: f64) -> f64 {
    trig::exp(p * trig::ln(x))
}

#[test]
fn exact_powers_are_found_exactly() {
    let of = |seed: u64| {
        let c = 1e-3 * (seed as f64 - 6.0);
        let sample = |k: u64| {
            let s = 0.1 * k as f64;
            at(s, c * power(s, 1.5), c * power(s, 0.5))
        };
        track(3, seed, (1..=60).map(sample).collect())
    };
    let tracks: Vec<Track> = (0..12).map(of).collect();
    let [found] = &growth(&tracks)[..] else { panic!("one group") };
    assert_eq!((found.cell, found.estimator.as_str()), (3, "dead-reckoning"));
    let (across, heading) = (found.exponents.log_across.unwrap(), found.exponents.heading.unwrap());
    assert!((across.law.exponent - 1.5).abs() < 1e-9, "{across:?}");
    assert!((heading.law.exponent - 0.5).abs() < 1e-9, "{heading:?}");
    // Every seed says the same, so leaving some out changes nothing.
    assert!(across.standard_error < 1e-9 && heading.standard_error < 1e-9);
    // From a sixth of 6 m on.
    assert_eq!((across.law.points, across.law.range[1]), (51, 6.0));
    assert!((across.law.range[0] - 1.0).abs() < 1e-12);
    assert_eq!(found.exponents.log_along, None, "nothing spreads along the track");
    let last = found.samples.last().unwrap();
    assert!((last.position_m / last.log_across_m.standard_deviation - 1.0).abs() < 1e-3);
}

/// White heading increments, summed, and summed once more across the track.
fn walk(seed: u64, ticks: u64) -> Track {
    let mut noise = TickNoise::slip(seed);
    let (mut heading_rad, mut across_m, mut samples) = (0.0, 0.0, Vec::new());
    for tick in 0..ticks {
        heading_rad += 1e-3 * noise.normals::<2>(tick)[0];
        across_m += 0.05 * heading_rad;
        if (tick + 1).is_multiple_of(ticks / 50) {
            samples.push(at(0.05 * (tick + 1) as f64, across_m, heading_rad));
        }
    }
    track(0, seed, samples)
}

#[test]
fn a_random_walk_has_one_half_and_its_sum_three_halves() {
    let tracks: Vec<Track> = (0..600).map(|seed| walk(seed, 300)).collect();
    let found = &growth(&tracks)[0].exponents;
    for (exponent, expected) in [(found.heading, 0.5), (found.log_across, 1.5)] {
        let Exponent { law, standard_error } = exponent.unwrap();
        assert!((0.003..0.1).contains(&standard_error), "{standard_error}");
        let off = (law.exponent - expected).abs();
        assert!(off < 4.0 * standard_error && off < 0.1, "{law:?} ± {standard_error}");
    }
}

#[test]
fn the_standard_error_is_how_far_ensembles_scatter() {
    let ensembles: Vec<Exponent> = (0..24)
        .map(|e| {
            let tracks: Vec<Track> = (0..60).map(|k| walk(1000 * e + k, 100)).collect();
            growth(&tracks)[0].exponents.heading.unwrap()
        })
        .collect();
    let exponents: Vec<f64> = ensembles.iter().map(|e| e.law.exponent).collect();
    let claimed = ensembles.iter().map(|e| e.standard_error).sum::<f64>() / 24.0;
    let scatter = Moments::of(&exponents).standard_deviation;
    // A standard deviation of 24 numbers is known to 15 %.
    assert!((0.6..1.6).contains(&(claimed / scatter)), "{claimed} for {scatter}");
}

#[test]
fn the_laboratory_of_seeds_grows_as_the_chapter_says() {
    let config = straight_leg();
    let tracks: Vec<Track> = (0..480).map(|seed| reckoned(&config, 0, seed, 1)).collect();
    let found = &growth(&tracks)[0];
    for (tick, expected_m) in [(9, 0.021), (19, 0.057), (29, 0.101)] {
        let spread_m = found.samples[tick].position_m;
        assert!((spread_m / expected_m - 1.0).abs() < 0.10, "{tick}: {spread_m}");
    }
    let last = found.samples[29];
    // Worked out: steps of 0.05 m with a slip of 0.05 in each wheel, 30 times.
    let along_m = 0.05 * 0.05 * 15.0_f64.sqrt();
    let turn_rad = 0.05 * 0.05 * 2.0_f64.sqrt() / 0.16;
    let heading_rad = turn_rad * 30.0_f64.sqrt();
    // A tick's turn is carried on by half its own step and all later ones.
    let across_m =
        0.05 * turn_rad * (0..30).map(|k| f64::from(k) + 0.5).map(|k| k * k).sum::<f64>().sqrt();
    for (found, worked_out) in [
        (last.log_along_m.standard_deviation, along_m),
        (last.log_across_m.standard_deviation, across_m),
        (last.heading_rad.standard_deviation, heading_rad),
    ] {
        // A standard deviation of 480 numbers is known to 3.2 %.
        assert!((found / worked_out - 1.0).abs() < 0.10, "{found} for {worked_out}");
    }
    assert!((8.0..10.0).contains(&last.across_over_along), "{last:?}");
    let e = found.exponents;
    let near = |exponent: Option<Exponent>, low: f64, high: f64| {
        let law = exponent.unwrap().law;
        assert!((low..=high).contains(&law.exponent), "{law:?}");
    };
    near(e.position, 1.40, 1.50);
    near(e.log_across, 1.40, 1.55);
    near(e.log_along, 0.45, 0.55);
    near(e.heading, 0.45, 0.55);
}

#[test]
fn what_is_systematic_has_a_mean_and_no_exponent() {
    let mut config = straight_leg();
    config.robot.slip_std = 0.0;
    config.robot.radius_bias_right = 0.01;
    let tracks: Vec<Track> = (0..5).map(|seed| reckoned(&config, 0, seed, 3)).collect();
    let found = &growth(&tracks)[0];
    assert_eq!(found.exponents, Exponents::default());
    let mean = |i: usize| found.samples[i].heading_rad.mean;
    // −δ·s/ℓ: the belief is left behind, and proportionally to the way.
    assert!((mean(9) / (-0.01 * 1.5 / 0.16) - 1.0).abs() < 1e-3, "{}", mean(9));
    assert!((mean(9) / mean(4) - 2.0).abs() < 1e-2);
    assert!(found.samples[9].mean_error_m > 0.05);
}

#[test]
fn odd_tracks_do_no_harm() {
    assert!(growth(&[]).is_empty());
    let empty = growth(&[track(0, 1, Vec::new())]);
    assert!(empty[0].samples.is_empty() && empty[0].exponents == Exponents::default());
    let one = growth(&[walk(1, 100)]);
    assert_eq!((one[0].samples.len(), one[0].exponents), (50, Exponents::default()));
    // Two seeds have a line, and no way to say how far it is known.
    let two = growth(&[walk(1, 100), walk(2, 100)]);
    assert!(two[0].exponents.heading.unwrap().standard_error.is_nan());
    // One that lacks samples is missed where it lacks them.
    let mut holes = walk(3, 100);
    holes.samples.drain(7..40);
    let found = growth(&[walk(1, 100), holes]);
    let counts: Vec<usize> = found[0].samples.iter().map(|s| s.across_m.n).collect();
    assert_eq!((counts.len(), counts[6], counts[7], counts[40]), (50, 2, 1, 2));
}
