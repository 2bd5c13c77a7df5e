//! The noise compared with the well-known crates: `rand_distr` drawing from the same
//! kind of generator must not be told apart from ours.

#![allow(clippy::unwrap_used)]

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use rusty_sim::noise::{LidarNoise, TickNoise};

const DRAWS: usize = 200_000;

/// Largest distance between two empirical distributions (Kolmogorov and
/// Smirnov).
fn distance(a: &mut [f64], b: &mut [f64]) -> f64 {
    a.sort_by(f64::total_cmp);
    b.sort_by(f64::total_cmp);
    let (mut i, mut j, mut largest) = (0, 0, 0.0f64);
    while i < a.len() && j < b.len() {
        if a[i] <= b[j] {
            i += 1;
        } else {
            j += 1;
        }
        largest = largest.max((i as f64 / a.len() as f64 - j as f64 / b.len() as f64).abs());
    }
    largest
}

/// The distance that two samples of this size exceed once in ten thousand
/// times: 2.225·√(2/n) (Smirnov's asymptotic law at α = 1e-4).
fn limit() -> f64 {
    2.225 * (2.0 / DRAWS as f64).sqrt()
}

fn reference(seed: u64) -> Vec<f64> {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    (0..DRAWS).map(|_| StandardNormal.sample(&mut generator)).collect()
}

#[test]
fn slip_is_distributed_as_rand_distr_s_normal() {
    let mut noise = TickNoise::slip(11);
    let mut ours: Vec<f64> =
        (0..DRAWS as u64 / 2).flat_map(|tick| noise.normals::<2>(tick)).collect();
    let found = distance(&mut ours, &mut reference(12));
    assert!(found < limit(), "{found}");
}

#[test]
fn ranges_are_distributed_as_rand_distr_s_normal() {
    let mut noise = LidarNoise::new(13);
    let mut ours = Vec::with_capacity(DRAWS);
    for tick in 0..DRAWS as u64 / 200 {
        ours.extend(noise.at(tick, 200).map(|draw| draw.z));
    }
    let found = distance(&mut ours, &mut reference(14));
    assert!(found < limit(), "{found}");
}

#[test]
fn the_comparison_sees_three_percent_of_scale() {
    let mut ours = reference(15).iter().map(|z| 1.03 * z).collect::<Vec<_>>();
    assert!(distance(&mut ours, &mut reference(16)) > limit());
}
