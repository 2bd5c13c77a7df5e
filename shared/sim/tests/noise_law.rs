//! The noise has the law it claims: bin by bin against the density, with the
//! probabilities integrated here and not taken from the code under test.

mod common;

use rusty_contract::LidarConfig;
use rusty_geometry::{Hit, SE2, apartment, trig};
use rusty_sim::Lidar;
use rusty_sim::noise::{LidarNoise, TickNoise};

/// Bins of the statistic: 64 from −4 to 4, and one for each tail.
const INNER: usize = 64;
const FROM: f64 = -4.0;
const WIDTH: f64 = 0.125;

fn density(z: f64) -> f64 {
    trig::exp(-0.5 * z * z) / (2.0 * std::f64::consts::PI).sqrt()
}

/// Probability of each bin, by Simpson's rule with eight strips.
fn probabilities() -> Vec<f64> {
    let mut bins = vec![0.0];
    for bin in 0..INNER {
        let left = FROM + WIDTH * bin as f64;
        let h = WIDTH / 8.0;
        let weighted = |i: i32| {
            let weight = match i {
                0 | 8 => 1.0,
                _ if i % 2 == 1 => 4.0,
                _ => 2.0,
            };
            weight * density(left + h * f64::from(i))
        };
        bins.push((0..=8).map(weighted).sum::<f64>() * h / 3.0);
    }
    let tail = 0.5 * (1.0 - bins.iter().sum::<f64>());
    bins[0] = tail;
    bins.push(tail);
    bins
}

/// Pearson's statistic of `values` against the standard normal law; 65 degrees of
/// freedom, so about 65 ± 11.4.
fn chi_square(values: &[f64]) -> f64 {
    let mut counts = vec![0_u64; INNER + 2];
    for z in values {
        let bin = ((z - FROM) / WIDTH).floor() + 1.0;
        counts[bin.clamp(0.0, (INNER + 1) as f64) as usize] += 1;
    }
    let n = values.len() as f64;
    let terms = counts.iter().zip(probabilities()).map(|(count, p)| {
        let off = *count as f64 - n * p;
        off * off / (n * p)
    });
    terms.sum()
}

/// Within 3.7 σ of its mean on either side: one law in ten thousand fails.
fn assert_normal(values: &[f64]) {
    let statistic = chi_square(values);
    assert!((28.0..=112.0).contains(&statistic), "chi-square {statistic}");
}

fn correlation(pairs: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    let (mut n, mut sum) = (0.0, 0.0);
    for (a, b) in pairs {
        n += 1.0;
        sum += a * b;
    }
    (sum / n, 4.0 / f64::sqrt(n))
}

fn assert_independent(pairs: impl Iterator<Item = (f64, f64)>) {
    let (found, limit) = correlation(pairs);
    assert!(found.abs() < limit, "{found} beyond {limit}");
}

#[test]
fn slip_is_standard_normal_and_independent() {
    let mut noise = TickNoise::slip(2024);
    let drawn: Vec<[f64; 2]> = (0..250_000).map(|tick| noise.normals::<2>(tick)).collect();
    assert_normal(&drawn.concat());
    assert_independent(drawn.iter().map(|[left, right]| (*left, *right)));
    assert_independent(drawn.windows(2).map(|w| (w[0][1], w[1][0])));
    assert_independent(drawn.windows(2).map(|w| (w[0][0], w[1][0])));
}

#[test]
fn the_test_notices_one_percent() {
    let mut noise = TickNoise::slip(2024);
    let drawn: Vec<[f64; 2]> = (0..250_000).map(|tick| noise.normals::<2>(tick)).collect();
    let wider: Vec<f64> = drawn.concat().iter().map(|z| 1.01 * z).collect();
    assert!(chi_square(&wider) > 112.0);
    let shifted: Vec<f64> = drawn.concat().iter().map(|z| z + 0.02).collect();
    assert!(chi_square(&shifted) > 112.0);
}

/// Scans of 4000 ticks from one place, and what a perfect sensor would see.
fn scans(config: &LidarConfig) -> (Vec<Vec<f64>>, Vec<Hit>) {
    let (mut lidar, world) = (Lidar::new(config), apartment());
    let pose = SE2::new(4.9, 2.84, 0.3);
    let nothing = Hit { distance_m: f64::NAN, material: None };
    let mut hits = vec![nothing; lidar.beams()];
    lidar.ranges_and_materials(&world, &pose, &mut hits);
    let mut noise = LidarNoise::new(99);
    let scan = |tick| {
        let mut ranges_m = vec![f64::NAN; lidar.beams()];
        lidar.scan(&world, &pose, &mut noise, tick, &mut ranges_m);
        ranges_m
    };
    ((0..4000).map(scan).collect(), hits)
}

#[test]
fn range_errors_of_real_scans_are_normal() {
    let (scans, hits) = scans(&LidarConfig::default());
    let errors: Vec<Vec<f64>> = scans
        .iter()
        .map(|scan| {
            let pairs = scan.iter().zip(&hits);
            pairs.map(|(r, h)| (r - h.distance_m) / 0.02).collect()
        })
        .collect();
    assert_normal(&errors.concat());
    // Beam against its neighbour, scan against the next.
    assert_independent(errors.iter().flat_map(|e| e.windows(2).map(|w| (w[0], w[1]))));
    let consecutive = errors.windows(2);
    assert_independent(consecutive.flat_map(|w| w[0].iter().copied().zip(w[1].iter().copied())));
}

#[test]
fn dropout_has_its_frequency_on_every_beam() {
    let config = LidarConfig { dropout: 0.2, ..LidarConfig::default() };
    let (scans, _) = scans(&config);
    let lost = |k: usize| scans.iter().filter(|scan| scan[k] == 8.0).count() as f64;
    let n = scans.len() as f64;
    let per_beam: Vec<f64> = (0..180).map(lost).collect();
    let all = per_beam.iter().sum::<f64>() / (180.0 * n);
    let sigma = f64::sqrt(0.2 * 0.8 / (180.0 * n));
    assert!((all - 0.2).abs() < 4.0 * sigma, "{all}");
    // Over the beams, the statistic has 180 degrees of freedom: 180 ± 19.
    let terms = per_beam.iter().map(|count| {
        let off = count - 0.2 * n;
        off * off / (0.16 * n)
    });
    let statistic: f64 = terms.sum();
    assert!((110.0..=255.0).contains(&statistic), "{statistic}");
}

#[test]
fn whether_a_beam_drops_out_says_nothing_of_its_error() {
    let mut noise = LidarNoise::new(31);
    let draws: Vec<_> =
        (0..2000).flat_map(|tick| noise.at(tick, 180).collect::<Vec<_>>()).collect();
    // √12 (u − ½) has variance one.
    let centred = |u: f64| 12.0_f64.sqrt() * (u - 0.5);
    assert!(draws.iter().all(|d| (0.0..1.0).contains(&d.u)));
    assert_independent(draws.iter().map(|d| (centred(d.u), d.z)));
    assert_independent(
        draws.iter().map(|d| (centred(d.u), d.z * d.z - 1.0)).map(|(a, b)| (a, b / 2.0_f64.sqrt())),
    );
}
