//! Mean and spread of numbers.

use rusty_contract::score::Statistics;
use serde::Serialize;

/// Mean and spread of a list of numbers, in the unit of the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Moments {
    /// How many.
    pub n: usize,
    /// Their mean; NaN where there are none.
    pub mean: f64,
    /// Their standard deviation, with n − 1 in the denominator; 0 for fewer
    /// than two.
    pub standard_deviation: f64,
}

impl Moments {
    /// Of `values`, summed in the order they come in.
    #[must_use]
    pub fn of(values: &[f64]) -> Self {
        let mut all = Running::default();
        values.iter().for_each(|value| all.push(*value));
        let n = values.len();
        let variance = if n < 2 { 0.0 } else { all.deviation2 / (n - 1) as f64 };
        Self { n, mean: all.mean(), standard_deviation: variance.sqrt() }
    }

    /// Standard error of the mean: the standard deviation over √n; NaN for fewer than two.
    #[must_use]
    pub fn standard_error(&self) -> f64 {
        match self.n {
            0 | 1 => f64::NAN,
            n => self.standard_deviation / (n as f64).sqrt(),
        }
    }

    /// Variance of the mean: 0 for one number, NaN for an empty list.
    #[must_use]
    pub fn variance_of_mean(&self) -> f64 {
        let standard_error = self.standard_deviation / (self.n as f64).sqrt();
        standard_error * standard_error
    }
}

/// Correlation of two series of the same length (Pearson), between −1 and 1; NaN
/// where one of them has no spread.
#[must_use]
pub fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let [of_a, of_b] = [a, b].map(Moments::of);
    if !(of_a.standard_deviation > 0.0 && of_b.standard_deviation > 0.0) {
        return f64::NAN;
    }
    let products = a.iter().zip(b).map(|(a, b)| (a - of_a.mean) * (b - of_b.mean));
    let covariance = products.sum::<f64>() / (a.len() as f64 - 1.0);
    covariance / (of_a.standard_deviation * of_b.standard_deviation)
}

/// Sums over numbers that come one by one.
///
/// Source: B. P. Welford, *Note on a method for calculating corrected sums of squares
/// and products*, Technometrics 4 (1962), for the squared deviations: a small spread
/// about a large mean keeps its digits.
#[derive(Clone, Debug, Default)]
pub struct Running {
    count: u64,
    sum: f64,
    squares: f64,
    center: f64,
    deviation2: f64,
    least: f64,
    greatest: f64,
}

impl Running {
    /// Takes the next value.
    pub fn push(&mut self, value: f64) {
        if self.count == 0 {
            (self.least, self.greatest) = (value, value);
        }
        self.count += 1;
        self.sum += value;
        self.squares += value * value;
        let from_center = value - self.center;
        self.center += from_center / self.count as f64;
        self.deviation2 += from_center * (value - self.center);
        self.least = self.least.min(value);
        self.greatest = self.greatest.max(value);
    }

    /// Number of values.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Mean; NaN without a value.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.sum / self.count as f64
    }

    /// Root of the mean square; NaN without a value.
    #[must_use]
    pub fn rms(&self) -> f64 {
        (self.squares / self.count as f64).sqrt()
    }

    /// The greatest value; 0 without one.
    #[must_use]
    pub fn greatest(&self) -> f64 {
        self.greatest
    }

    /// Variance, divided by the count; 0 without a value.
    #[must_use]
    pub fn variance(&self) -> f64 {
        if self.count == 0 { 0.0 } else { self.deviation2 / self.count as f64 }
    }

    /// The figures of `evo.core.metrics.PE.get_statistic` (evo 1.38.1), with a median
    /// from elsewhere. `None` without a value, and where a figure is not finite: an
    /// error of 10²⁰⁰ m has no square.
    #[must_use]
    pub fn statistics(&self, median: Option<f64>) -> Option<Statistics> {
        let found = Statistics {
            count: self.count,
            rmse: self.rms(),
            mean: self.mean(),
            median: median?,
            std: self.variance().sqrt(),
            min: self.least,
            max: self.greatest,
            sse: self.squares,
        };
        let Statistics { count: _, rmse, mean, median, std, min, max, sse } = found;
        [rmse, mean, median, std, min, max, sse].iter().all(|v| v.is_finite()).then_some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_a_list_known_by_heart() {
        let m = Moments::of(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]);
        assert_eq!((m.n, m.mean), (8, 5.0));
        assert!((m.standard_deviation - (32.0_f64 / 7.0).sqrt()).abs() < 1e-15);
        assert!((m.standard_error() - (4.0_f64 / 7.0).sqrt()).abs() < 1e-15);
        // A spread of 1 about 10⁹, where a sum of squares would have lost it.
        let far = Moments::of(&[1e9 - 1.0, 1e9, 1e9 + 1.0]);
        assert_eq!((far.mean, far.standard_deviation), (1e9, 1.0));
        let one = Moments::of(&[7.0]);
        assert!(one.standard_deviation == 0.0 && one.standard_error().is_nan());
        assert!(Moments::of(&[]).mean.is_nan());
    }

    #[test]
    fn a_correlation_is_of_slopes_and_needs_spread() {
        let a = [1.0, 2.0, 4.0];
        assert!((correlation(&a, &[-2.0, -4.0, -8.0]) + 1.0).abs() < 1e-15);
        // Deviations (−4, −1, 5)/3 and (−1, 2, −1): products 3·(−1)/3 of √(14/3 · 6).
        assert!((correlation(&a, &[0.0, 3.0, 0.0]) + 1.0 / 28.0_f64.sqrt()).abs() < 1e-15);
        assert!(correlation(&a, &[5.0; 3]).is_nan() && correlation(&[], &[]).is_nan());
    }
}
