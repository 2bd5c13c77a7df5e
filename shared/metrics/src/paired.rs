//! A figure of A and B on the same seeds: the difference, seed by seed.
//!
//! The interval of the mean difference is Student's t. For comparison there is that of
//! two independent samples, with the degrees of freedom of B. Welch (Biometrika 34,
//! 1947). The ratio of their widths, squared, is the factor by which more runs would
//! have been needed without the pairing (A. Law and W. Kelton, *Simulation Modeling and
//! Analysis*, §11.2, common random numbers). Below 1 the pairing did harm.

use std::collections::BTreeMap;

use serde::Serialize;

use super::moments::{Moments, correlation};
use super::sign_test::SignTest;
use super::student::{half_width, t_two_sided};

/// A figure of A and of B over the seeds that both have.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Paired {
    /// Seeds with a figure of both.
    pub pairs: usize,
    /// Mean of A, and of B, over those seeds.
    pub means: [f64; 2],
    /// B − A, mean over the seeds.
    pub difference: f64,
    /// Half the width of its interval, seed by seed; NaN with fewer than two
    /// pairs.
    pub paired_half_width: f64,
    /// Half the width that two independent samples of this size and spread
    /// would have (Welch); NaN with fewer than two pairs.
    pub unpaired_half_width: f64,
    /// (unpaired over paired half width)²: how many times as many runs the
    /// unpaired comparison needs; infinite where the differences have no spread.
    pub variance_reduction: f64,
    /// Correlation of A and B over the seeds; NaN where one has no spread.
    pub correlation: f64,
    /// Seeds without a figure of A; of B.
    pub missing: [Vec<u64>; 2],
    /// Signs of the differences B − A.
    #[serde(skip)]
    pub signs: SignTest,
}

impl Paired {
    /// Of the figures of A and B by seed, with intervals at `level` (0.95).
    #[must_use]
    pub fn of(figures: &BTreeMap<u64, [Option<f64>; 2]>, level: f64) -> Self {
        let without = |side: usize| {
            let lacking = figures.iter().filter(|(_, figures)| figures[side].is_none());
            lacking.map(|(seed, _)| *seed).collect()
        };
        let both = figures.values().filter_map(|[a, b]| Some(((*a)?, (*b)?)));
        let (a, b): (Vec<f64>, Vec<f64>) = both.unzip();
        let differences: Vec<f64> = a.iter().zip(&b).map(|(a, b)| b - a).collect();
        let [of_a, of_b, of_difference] = [&a, &b, &differences].map(|all| Moments::of(all));
        let paired_half_width = half_width(&of_difference, level);
        let unpaired_half_width = welch_half_width(&of_a, &of_b, level);
        let ratio = unpaired_half_width / paired_half_width;
        Self {
            pairs: differences.len(),
            means: [of_a.mean, of_b.mean],
            difference: of_difference.mean,
            paired_half_width,
            unpaired_half_width,
            variance_reduction: ratio * ratio,
            correlation: correlation(&a, &b),
            missing: [without(0), without(1)],
            signs: SignTest::of(&differences),
        }
    }

    /// The interval of the difference; NaN with fewer than two pairs.
    #[must_use]
    pub fn interval(&self) -> [f64; 2] {
        [self.difference - self.paired_half_width, self.difference + self.paired_half_width]
    }
}

/// Half the width of the interval of the difference of two independent means
/// whose variances may differ.
fn welch_half_width(a: &Moments, b: &Moments, level: f64) -> f64 {
    if a.n < 2 || b.n < 2 {
        return f64::NAN;
    }
    let (va, vb) = (a.variance_of_mean(), b.variance_of_mean());
    if va + vb == 0.0 {
        return 0.0;
    }
    let square = |v: f64| v * v;
    let degrees = square(va + vb) / (square(va) / (a.n - 1) as f64 + square(vb) / (b.n - 1) as f64);
    t_two_sided(degrees, level) * (va + vb).sqrt()
}
