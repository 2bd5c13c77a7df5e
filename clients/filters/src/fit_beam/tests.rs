//! Numbers that are known are found again.

use super::*;
use crate::Random;

const RANGE_MAX_M: f64 = 8.0;

/// Readings drawn from the mixture, before walls 1 m to 7.9 m away.
fn drawn(model: &BeamModel, count: usize, seed: u64) -> Readings {
    let mut random = Random::new(seed, 1);
    let all = (0..count)
        .map(|k| {
            let expected_m = 1.0 + 6.9 * (k as f64 / count as f64);
            let u = random.uniform();
            let range_m = if u < model.z_hit {
                loop {
                    let range_m = expected_m + model.sigma_hit_m * random.normal();
                    if (0.0..RANGE_MAX_M).contains(&range_m) {
                        break range_m;
                    }
                }
            } else if u < model.z_hit + model.z_short {
                let u = random.uniform();
                let mass = 1.0 - trig::exp(-model.lambda_short_per_m * expected_m);
                -trig::ln(1.0 - u * mass) / model.lambda_short_per_m
            } else if u < model.z_hit + model.z_short + model.z_max {
                RANGE_MAX_M
            } else {
                random.uniform() * RANGE_MAX_M
            };
            Reading { range_m, expected_m }
        })
        .collect();
    Readings { range_max_m: RANGE_MAX_M, all }
}

fn guess() -> BeamModel {
    BeamModel {
        z_hit: 0.7,
        z_short: 0.1,
        z_max: 0.1,
        z_rand: 0.1,
        sigma_hit_m: 0.5,
        lambda_short_per_m: 0.2,
    }
}

fn numbers(fit: &BeamFit) -> [Fitted; 6] {
    [fit.z_hit, fit.z_short, fit.z_max, fit.z_rand, fit.sigma_hit_m, fit.lambda_short_per_m]
}

const MIXTURE: BeamModel = BeamModel {
    z_hit: 0.62,
    z_short: 0.2,
    z_max: 0.06,
    z_rand: 0.12,
    sigma_hit_m: 0.15,
    lambda_short_per_m: 0.9,
};

#[test]
fn a_mixture_is_found_again_within_its_standard_errors() {
    let truth = [0.62, 0.2, 0.06, 0.12, 0.15, 0.9];
    let mut squares = [0.0; 6];
    let seeds = 8;
    for seed in 0..seeds {
        let fit = fit(&drawn(&MIXTURE, 5000, seed), guess(), Criterion::default()).unwrap();
        assert!(fit.converged);
        for (i, (found, truth)) in numbers(&fit).iter().zip(truth).enumerate() {
            let off = (found.value - truth) / found.std_error.unwrap();
            assert!(off.abs() < 3.5, "seed {seed}, {i}: {found:?} for {truth}");
            squares[i] += off * off / f64::from(seeds as u32);
        }
    }
    // Errors are as large as they are said to be: χ² with 8 degrees over 8.
    assert!(squares.iter().all(|s| (0.25..2.6).contains(s)), "{squares:?}");
}

#[test]
fn the_likelihood_never_falls() {
    for (seed, model) in [(1, MIXTURE), (2, BeamModel { sigma_hit_m: 1.5, ..MIXTURE })] {
        let fit = fit(&drawn(&model, 4000, seed), guess(), Criterion::default()).unwrap();
        for (i, pair) in fit.rounds.windows(2).enumerate() {
            let [before, after] = [pair[0].log_likelihood, pair[1].log_likelihood];
            assert!(after >= before - 1e-12, "round {i}: {before} to {after}");
        }
        let weights = fit.rounds.last().unwrap().weights;
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn one_round_is_the_book_s_table_by_hand() {
    // Two readings at 3 m: one there, one of nothing.
    let all =
        vec![Reading { range_m: 3.1, expected_m: 3.0 }, Reading { range_m: 8.0, expected_m: 3.0 }];
    let readings = Readings { range_max_m: RANGE_MAX_M, all };
    let once = Criterion { rounds: 1, ..Criterion::default() };
    let fit = fit(&readings, guess(), once).unwrap();
    let e = guess().responsibilities(3.1, 3.0, RANGE_MAX_M);
    let last = fit.rounds.last().unwrap();
    assert_eq!(fit.rounds.len(), 2);
    assert_eq!(numbers(&fit)[..4].iter().map(|n| n.value).collect::<Vec<_>>(), last.weights);
    assert_eq!(fit.sigma_hit_m.value, last.sigma_hit_m);
    assert_eq!(fit.lambda_short_per_m.value, last.lambda_short_per_m);
    for (found, wanted) in last.weights.iter().zip([0.5 * e.hit, 0.0, 0.5, 0.5 * e.rand]) {
        assert!((found - wanted).abs() < 1e-15, "{last:?}");
    }
    // Only the first was a hit, 0.1 m off.
    assert!((last.sigma_hit_m - 0.1).abs() < 1e-12);
}

#[test]
fn a_wide_hit_is_found_wherever_the_search_begins() {
    let wide = BeamModel { sigma_hit_m: 1.5, ..MIXTURE };
    let criterion = Criterion { tolerance: 1e-12, rounds: 20_000 };
    let found = [0.5, 3.0].map(|sigma_hit_m| {
        let guess = BeamModel { sigma_hit_m, ..guess() };
        let fit = fit(&drawn(&wide, 4000, 2), guess, criterion).unwrap();
        assert!(fit.converged, "{} rounds", fit.rounds.len());
        fit.sigma_hit_m
    });
    let std_error = found[0].std_error.unwrap();
    assert!((found[0].value - found[1].value).abs() < 0.02 * std_error, "{found:?}");
    assert!((found[0].value - 1.5).abs() < 3.0 * std_error && std_error < 0.3, "{found:?}");
}

#[test]
fn sigma_is_where_its_likelihood_is_greatest() {
    let squares = [[0.9, 0.4, 0.7], [0.5, 7.5, -2.0], [1.0, 4.0, 1.5], [0.3, 6.0, -0.2]];
    let hits = squares.map(|[e, expected_m, _]| [e, expected_m]);
    let sum_m2: f64 = squares.iter().map(|[e, _, off_m]| e * off_m * off_m).sum();
    let likelihood = |sigma_hit_m: f64| -> f64 {
        let model = BeamModel { sigma_hit_m, ..guess() };
        let of = |[e, expected_m, off_m]: &[f64; 3]| {
            e * trig::ln(model.parts(expected_m + off_m, *expected_m, RANGE_MAX_M).hit)
        };
        squares.iter().map(of).sum()
    };
    for start_m in [1e-5, 0.1, 3.0, 70.0] {
        let best = most_likely_sigma_m(start_m, sum_m2, &hits, RANGE_MAX_M);
        let there = likelihood(best);
        assert!(there > likelihood(best * 1.01) && there > likelihood(best / 1.01), "{best}");
    }
    // Errors of nothing, and errors that no law between the ends has.
    assert_eq!(most_likely_sigma_m(1.0, 0.0, &hits, RANGE_MAX_M), LEAST_SIGMA_M);
    assert_eq!(most_likely_sigma_m(1.0, 1e3, &hits, RANGE_MAX_M), MOST_SIGMA * RANGE_MAX_M);
    assert_eq!(most_likely_sigma_m(1.0, 0.0, &[], RANGE_MAX_M), 1.0);
}

#[test]
fn scores_are_the_slopes_of_the_log_likelihood() {
    let model = BeamModel { sigma_hit_m: 1.5, ..MIXTURE };
    for (range_m, expected_m) in [(3.0, 2.5), (0.5, 1.0), (7.5, 7.0), (6.0, 7.9)] {
        let slopes = score(&Reading { range_m, expected_m }, &model, RANGE_MAX_M).unwrap();
        let log = |model: BeamModel| trig::ln(model.density(range_m, expected_m, RANGE_MAX_M));
        let step = 1e-3;
        let of = |change: fn(&mut BeamModel, f64)| {
            let [mut more, mut less] = [model; 2];
            change(&mut more, step);
            change(&mut less, -step);
            (log(more) - log(less)) / (2.0 * step)
        };
        let by_sigma = of(|model, by| model.sigma_hit_m += by);
        let by_lambda = of(|model, by| model.lambda_short_per_m += by);
        assert!((slopes[3] - by_sigma).abs() < 2e-3, "{range_m}: {slopes} for {by_sigma}");
        assert!((slopes[4] - by_lambda).abs() < 2e-3, "{range_m}: {slopes} for {by_lambda}");
    }
}

#[test]
fn lambda_is_where_its_likelihood_is_greatest() {
    let shorts: Vec<[f64; 3]> =
        (1..60).map(|k| [0.3, 0.02 * f64::from(k), 1.0 + 0.1 * f64::from(k % 7)]).collect();
    let likelihood = |lambda: f64| -> f64 {
        let of = |[e, z, end]: &[f64; 3]| {
            e * (trig::ln(lambda) - lambda * z - trig::ln(1.0 - trig::exp(-lambda * end)))
        };
        shorts.iter().map(of).sum()
    };
    for start in [1e-3, 0.5, 7.0, 900.0] {
        let best = most_likely_lambda(start, &shorts);
        let there = likelihood(best);
        assert!(there >= likelihood(best * 1.001) && there >= likelihood(best / 1.001), "{best}");
    }
    // Farther is more: as flat as it may be; all at the sensor: as steep.
    assert_eq!(most_likely_lambda(1.0, &[[1.0, 2.9, 3.0]]), LEAST_LAMBDA);
    assert_eq!(most_likely_lambda(1.0, &[[1.0, 0.0, 3.0]]), 1.0 / LEAST_LAMBDA);
    assert_eq!(most_likely_lambda(1.0, &[]), 1.0);
}

#[test]
fn what_is_not_there_is_said_not_to_be() {
    let model = BeamModel { z_hit: 0.98, z_short: 0.0, z_max: 0.02, z_rand: 0.0, ..MIXTURE };
    let model = BeamModel { sigma_hit_m: 0.02, ..model };
    let fit = fit(&drawn(&model, 20_000, 5), guess(), Criterion::default()).unwrap();
    assert!(fit.z_short.value < 1e-6 && fit.z_rand.value < 1e-6, "{:?}", fit.rounds.last());
    // None of 20 000 readings: one in as many is as wide as the doubt goes.
    assert!((fit.z_short.std_error.unwrap() - 5e-5).abs() < 1e-5, "{:?}", fit.z_short);
    assert_eq!(fit.lambda_short_per_m.std_error, None);
    let off = |found: Fitted, truth: f64| (found.value - truth) / found.std_error.unwrap();
    assert!(off(fit.sigma_hit_m, 0.02).abs() < 3.0 && off(fit.z_max, 0.02).abs() < 3.0);
    // Errors in closed form: σ/√(2n) and √(p q / n).
    let n = 20_000_f64;
    assert!(
        (fit.sigma_hit_m.std_error.unwrap() / (0.02 / (2.0 * 0.98 * n).sqrt()) - 1.0).abs() < 0.05
    );
    assert!((fit.z_max.std_error.unwrap() / (0.02 * 0.98 / n).sqrt() - 1.0).abs() < 0.05);
}

#[test]
fn odd_readings_give_no_panic_and_no_nan() {
    let one = |range_m, expected_m| Reading { range_m, expected_m };
    for all in [
        vec![one(8.0, 8.0); 5],
        vec![one(3.0, 3.0); 5],
        vec![one(0.0, 0.0); 5],
        vec![one(8.0, 1.0); 5],
        vec![one(1.0, 0.0), one(8.0, 8.0)],
    ] {
        let readings = Readings { range_max_m: RANGE_MAX_M, all };
        let fit = fit(&readings, guess(), Criterion::default()).unwrap();
        for number in numbers(&fit) {
            assert!(
                number.value.is_finite() && number.std_error.is_none_or(f64::is_finite),
                "{fit:?}"
            );
        }
    }
    let none = Readings { range_max_m: RANGE_MAX_M, all: Vec::new() };
    assert_eq!(fit(&none, guess(), Criterion::default()), None);
}
