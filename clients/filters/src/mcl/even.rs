//! Particles that lie evenly, and not only by chance.
//!
//! Of 1000 particles about 100 have a heading that fits a scan. Where those survive by
//! chance, a direction that no beam sees, as along a single wall, loses a hundredth of its
//! variance with every scan, and its mean moves by as much. So the particles are put in order
//! along that direction before they are drawn, and the errors of their motions are points of
//! a sequence of which any few neighbours lie evenly: those that fit are then evenly spaced
//! in the order.
//!
//! Source: M. Gerber, N. Chopin, *Sequential quasi Monte Carlo* (Journal of the Royal
//! Statistical Society B 77(3), 2015), Algorithm 3, randomised by a shift. The points are those
//! of M. Roberts, *The unreasonable effectiveness of quasirandom sequences* (2018): multiples
//! of 1/φ, 1/φ² and 1/φ³ modulo 1, with φ⁴ = φ + 1. They become errors by the inverse of the
//! distribution function (W. T. Shaw, *Sampling Student's t distribution*, Journal of
//! Computational Finance 9(4), 2006, the case of two degrees of freedom).
//!
//! Departures, and why:
//! * While it is known where the robot is, or looked for around one place, errors have Student's t
//!   distribution with two degrees of freedom, not the normal one. In a quarter of the scans of
//!   CSAIL the heading of the wheels is off by more than four of the standard deviations that were
//!   expected, and the true pose had no particle. A robot that may be anywhere does not become
//!   easier to find by it.
//! * The order is that along the longest axis of the positions, not along a Hilbert curve:
//!   the other directions are those that scans see.
//! * The particles before a motion are drawn by the low-variance sampler of Table 4.4, for
//!   which one random number does what a coordinate of the sequence does.
//! * A belief of several modes is not put in order: with each mode in the order of all, three of
//!   eight runs on the recording of CSAIL followed a wrong mode for some scans.

use rusty_geometry::normals::standard_normals;
use rusty_geometry::trig;

use crate::Random;

/// 2⁶⁴ / φ, 2⁶⁴ / φ² and 2⁶⁴ / φ³: integers modulo 2⁶⁴ are exact.
const STEPS: [u64; 3] = [0xd1b5_4a32_d192_ed03, 0xabc9_8388_fb8f_ac03, 0x8cb9_2ba7_2f3d_8dd7];

const TWO_TO_64: f64 = 18_446_744_073_709_551_616.0;

/// √π/2: the errors are as dense in the middle as normal ones, so that as many of them fit a scan,
const MIDDLE: f64 = 0.886_226_925_452_758;
/// and none is larger than this, in standard deviations of the motion.
const MOST: f64 = 10.0;

/// Triples of errors that lie evenly, in standard deviations of a motion.
#[derive(Clone, Debug, Default)]
pub(super) struct EvenErrors {
    words: Vec<u64>,
    numbers: Vec<f64>,
}

impl EvenErrors {
    /// `count` triples, each of which alone is random: normal ones, or heavy-tailed ones.
    pub fn draw(&mut self, count: usize, are_heavy: bool, random: &mut Random) -> &[[f64; 3]] {
        let mut point = STEPS.map(|_| (random.uniform() * TWO_TO_64) as u64);
        self.words.clear();
        for _ in 0..count {
            self.words.extend(point);
            point.iter_mut().zip(STEPS).for_each(|(word, step)| *word = word.wrapping_add(step));
        }
        self.numbers.resize(3 * count, 0.0);
        if are_heavy {
            self.numbers.iter_mut().zip(&self.words).for_each(|(z, word)| *z = student(*word));
        } else {
            standard_normals(&self.words, &mut self.numbers);
        }
        self.numbers.as_chunks().0
    }
}

/// The quantile of Student's t distribution with two degrees of freedom, where the probability is
/// `word` of 2⁶⁴; scaled, and cut off.
fn student(word: u64) -> f64 {
    // The upper 52 bits and a half are exact: never 0 nor 1.
    let share = ((word >> 12) as f64 + 0.5) * 4096.0 / TWO_TO_64;
    let number = (2.0 * share - 1.0) / (2.0 * share * (1.0 - share)).sqrt();
    (MIDDLE * number).clamp(-MOST, MOST)
}

/// The `k`-th of normal numbers of which any few in a row lie evenly: the sequence of 1/φ
/// with φ² = φ + 1. The first is 0.
pub(super) fn even_normal(k: usize) -> f64 {
    let word = (k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(u64::MAX >> 1);
    let mut number = [0.0];
    standard_normals(&[word], &mut number);
    number[0]
}

/// The numbers of weighted positions in their order along the longest axis.
pub(super) fn order(x_m: &[f64], y_m: &[f64], weights: &[f64]) -> Vec<u32> {
    let all = || x_m.iter().zip(y_m).zip(weights);
    let mut mean = (0.0, 0.0);
    all().for_each(|((x, y), weight)| mean = (mean.0 + weight * x, mean.1 + weight * y));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for ((x, y), weight) in all() {
        let (x, y) = (x - mean.0, y - mean.1);
        (xx, xy, yy) = (xx + weight * x * x, xy + weight * x * y, yy + weight * y * y);
    }
    let (sin, cos) = trig::sin_cos(0.5 * trig::atan2(2.0 * xy, xx - yy));
    let along: Vec<f64> = all().map(|((x, y), _)| cos * x + sin * y).collect();
    let mut order: Vec<u32> = (0..along.len() as u32).collect();
    order.sort_by(|a, b| along[*a as usize].total_cmp(&along[*b as usize]));
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_powers_of_the_root_of_the_equation() {
        let mut phi = 1.2_f64;
        (0..60).for_each(|_| phi = (1.0 + phi).sqrt().sqrt());
        let mut share = 1.0;
        for step in STEPS {
            share /= phi;
            let found = step as f64 / TWO_TO_64;
            assert!((found - share).abs() < 1e-15, "{found} for {share}");
            assert_eq!(step % 2, 1);
        }
    }

    #[test]
    fn errors_are_quantiles_of_students_distribution() {
        // Tables of t with two degrees of freedom.
        for (share, expected) in
            [(0.25, -0.8165), (0.5, 0.0), (0.75, 0.8165), (0.95, 2.9200), (0.995, 9.9248)]
        {
            let found = student((share * TWO_TO_64) as u64) / MIDDLE;
            assert!((found - expected).abs() < 1e-4, "{share}: {found}");
        }
        assert_eq!([0, u64::MAX].map(student), [-MOST, MOST]);
    }

    #[test]
    fn a_thousand_heavy_triples_are_spread_far_better_than_by_chance() {
        let (mut even, mut random) = (EvenErrors::default(), Random::new(3, 1));
        let (mut errors, rounds) = ([0.0; 3], 20);
        for _ in 0..rounds {
            let triples = even.draw(1000, true, &mut random);
            for (i, error) in errors.iter_mut().enumerate() {
                // Their probabilities less a half: uniform numbers.
                let of_one = |t: f64| 0.5 * t / (2.0 * MIDDLE * MIDDLE + t * t).sqrt();
                let mean = triples.iter().map(|t| of_one(t[i])).sum::<f64>() / 1000.0;
                *error += mean * mean;
            }
        }
        // The variance of the mean of 1000 independent ones: 1/12000.
        let ratios = errors.map(|sum| sum * 12_000.0 / f64::from(rounds));
        assert!(ratios.iter().all(|ratio| *ratio < 0.05), "{ratios:?}");
    }

    #[test]
    fn a_thousand_triples_are_normal_far_better_than_by_chance() {
        let (mut normals, mut random) = (EvenErrors::default(), Random::new(3, 1));
        let (mut errors, rounds) = ([[0.0; 2]; 3], 20);
        for _ in 0..rounds {
            let triples = normals.draw(1000, false, &mut random);
            for (i, errors) in errors.iter_mut().enumerate() {
                let mean = triples.iter().map(|z| z[i]).sum::<f64>() / 1000.0;
                let square = triples.iter().map(|z| z[i] * z[i]).sum::<f64>() / 1000.0;
                errors[0] += mean * mean;
                errors[1] += (square - 1.0) * (square - 1.0);
            }
        }
        // The variances of 1000 independent ones: 1/1000 and 2/1000.
        for [of_mean, of_square] in errors {
            let ratios = [of_mean * 1000.0, of_square * 500.0].map(|sum| sum / f64::from(rounds));
            assert!(ratios[0] < 0.05 && ratios[1] < 0.5, "{ratios:?}");
        }
    }

    #[test]
    fn each_triple_alone_is_random() {
        let (mut normals, mut random) = (EvenErrors::default(), Random::new(4, 1));
        let (mut means, mut products, rounds) = ([0.0; 3], [[0.0; 3]; 3], 20_000);
        for _ in 0..rounds {
            let last = normals.draw(7, false, &mut random)[6];
            for i in 0..3 {
                means[i] += last[i] / f64::from(rounds);
                (0..3).for_each(|j| products[i][j] += last[i] * last[j] / f64::from(rounds));
            }
        }
        for i in 0..3 {
            assert!(means[i].abs() < 0.03, "{means:?}");
            for j in 0..3 {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((products[i][j] - expected).abs() < 0.04, "{products:?}");
            }
        }
    }

    #[test]
    fn normal_numbers_in_a_row_are_even_from_the_first_one_on() {
        assert!(even_normal(0).abs() < 1e-9);
        for first in [0, 1, 500] {
            for count in [100, 1000] {
                let numbers: Vec<f64> = (first..first + count).map(even_normal).collect();
                let mean = numbers.iter().sum::<f64>() / count as f64;
                let square = numbers.iter().map(|z| z * z).sum::<f64>() / count as f64;
                assert!(mean.abs() < 5.0 / count as f64, "{first}, {count}: {mean}");
                assert!((square - 1.0).abs() < 20.0 / count as f64, "{first}, {count}: {square}");
            }
        }
    }

    #[test]
    fn positions_are_in_order_along_their_longest_axis() {
        let ways = [3.0, 1.0, 4.0, 2.0, 0.0];
        // Along a line of 120°, a little to its sides.
        let side = |k: f64| if k == 2.0 { 0.1 } else { 0.0 };
        let [x_m, y_m] = [-0.5, 0.866].map(|slope| ways.map(|k| slope * k + side(k)));
        let order = order(&x_m, &y_m, &[0.2; 5]);
        assert!(order == [4, 1, 3, 0, 2] || order == [2, 0, 3, 1, 4], "{order:?}");
        assert!(super::order(&[], &[], &[]).is_empty());
    }
}
