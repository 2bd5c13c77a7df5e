//! Two figures on the same seeds: the difference, pair by pair.
//!
//! What chance adds to one of a pair it adds to the other, so the difference is
//! taken pair by pair and its interval is that of a mean of n differences
//! (Student's t, n − 1 degrees of freedom). Beside it stands the interval of two
//! samples that had nothing to do with each other, with the degrees of freedom
//! of B. Welch (*The generalization of "Student's" problem when several different
//! population variances are involved*, Biometrika 34, 1947). The ratio of their
//! widths, squared, is the factor by which more runs would have been needed
//! without the pairing (A. Law and W. Kelton, *Simulation Modeling and Analysis*,
//! §11.2, common random numbers; they call it variance reduction). Below 1 the
//! pairing did harm: the two react to the same noise in opposite ways.

use super::student::t_two_sided;
use super::{Moments, SignTest};

/// What pairs (a, b) say of the difference b − a.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pairs {
    /// How many.
    pub n: usize,
    /// Mean of the first of each pair, and of the second.
    pub means: [f64; 2],
    /// b − a, mean over the pairs.
    pub difference: f64,
    /// Half the width of its interval, pair by pair; NaN with fewer than two
    /// pairs.
    pub half_width: f64,
    /// Half the width that two independent samples of this size and spread
    /// would have (Welch); NaN with fewer than two pairs.
    pub unpaired_half_width: f64,
    /// (unpaired over paired half width)²: how many times as many runs the
    /// unpaired comparison needs; infinite where the differences have no spread.
    pub variance_reduction: f64,
    /// Correlation of the two; NaN where one has no spread.
    pub correlation: f64,
    /// In how many the second is less, and more.
    pub signs: SignTest,
}

impl Pairs {
    /// Of `a` and `b`, of equal length, with intervals at `level` (0.95).
    #[must_use]
    pub fn of(a: &[f64], b: &[f64], level: f64) -> Self {
        let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| b - a).collect();
        let [of_a, of_b, of_difference] = [a, b, &differences].map(Moments::of);
        let half_width = half_width(&of_difference, level);
        let unpaired_half_width = welch_half_width(&of_a, &of_b, level);
        let ratio = unpaired_half_width / half_width;
        Self {
            n: differences.len(),
            means: [of_a.mean, of_b.mean],
            difference: of_difference.mean,
            half_width,
            unpaired_half_width,
            variance_reduction: ratio * ratio,
            correlation: correlation(a, b),
            signs: SignTest::of(&differences),
        }
    }
}

/// Half the width of the interval of a mean at `level`; NaN of fewer than two.
#[must_use]
pub fn half_width(of: &Moments, level: f64) -> f64 {
    if of.n < 2 {
        return f64::NAN;
    }
    t_two_sided((of.n - 1) as f64, level) * of.standard_error()
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

/// Pearson's correlation.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let (of_a, of_b) = (Moments::of(a), Moments::of(b));
    let products = a.iter().zip(b).map(|(x, y)| (x - of_a.mean) * (y - of_b.mean));
    let covariance = products.sum::<f64>() / (a.len() as f64 - 1.0);
    covariance / (of_a.standard_deviation * of_b.standard_deviation)
}
