//! Mean, spread and quantiles of a list of numbers.

use rusty_contract::score::quantile;
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
    /// Of `values`, summed in the order they come in: two passes, so that a
    /// small spread about a large mean keeps its digits.
    #[must_use]
    pub fn of(values: &[f64]) -> Self {
        let n = values.len();
        let mean = values.iter().sum::<f64>() / n as f64;
        let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        let variance = if n < 2 { 0.0 } else { squares / (n - 1) as f64 };
        Self { n, mean, standard_deviation: variance.sqrt() }
    }

    /// Standard error of the mean: the standard deviation over √n; NaN where
    /// there are none.
    #[must_use]
    pub fn standard_error(&self) -> f64 {
        self.standard_deviation / (self.n as f64).sqrt()
    }

    /// Variance of the mean.
    #[must_use]
    pub fn variance_of_mean(&self) -> f64 {
        let standard_error = self.standard_error();
        standard_error * standard_error
    }
}

/// [`percentile`](rusty_contract::score::quantile::percentile) of values whose
/// order stays.
#[must_use]
pub fn percentile(values: &[f64], fraction: f64) -> Option<f64> {
    quantile::percentile(&mut values.to_vec(), fraction)
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
        assert_eq!(Moments::of(&[7.0]).standard_deviation, 0.0);
        assert!(Moments::of(&[]).mean.is_nan());
    }

    #[test]
    fn percentiles_are_linear_between_ranks() {
        let values = [15.0, 20.0, 35.0, 40.0, 50.0];
        assert_eq!(percentile(&values, 0.0), Some(15.0));
        assert_eq!(percentile(&values, 0.5), Some(35.0));
        assert_eq!(percentile(&values, 0.4), Some(20.0 + 0.6 * 15.0));
        assert_eq!(percentile(&values, 1.0), Some(50.0));
        assert_eq!(percentile(&[3.0], 0.95), Some(3.0));
        assert_eq!(percentile(&[], 0.95), None);
    }
}
