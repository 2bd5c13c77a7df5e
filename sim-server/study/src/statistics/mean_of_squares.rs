//! The mean of squared, normalised errors: where it lies if all is right.
//!
//! Source: Y. Bar-Shalom, X. Li, T. Kirubarajan, *Estimation with Applications
//! to Tracking and Navigation* (2001), §5.4.2: N independent errors of d degrees
//! of freedom, each normalised by its true covariance and squared, add up to χ²
//! with N·d degrees.

use rusty_contract::score::chi_square::band;

/// The mean of `n` independent ones of `degrees` each lies in here with
/// probability `level`, as often above as below; NaN where there are none.
#[must_use]
pub fn mean_interval(n: usize, degrees: f64, level: f64) -> [f64; 2] {
    if n == 0 || degrees.is_nan() || degrees <= 0.0 {
        return [f64::NAN; 2];
    }
    let n = n as f64;
    band(level, n * degrees).map(|end| end / n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_those_of_the_book() {
        // Bar-Shalom, Li, Kirubarajan: 50 runs, 2 degrees: χ²₁₀₀ from 74.22 to 129.6.
        let [low, high] = mean_interval(50, 2.0, 0.95);
        assert!((low - 74.222 / 50.0).abs() < 1e-4 && (high - 129.561 / 50.0).abs() < 1e-4);
        // One run of 3 degrees: 0.2158 and 9.3484.
        let [low, high] = mean_interval(1, 3.0, 0.95);
        assert!((low - 0.215_795).abs() < 1e-5 && (high - 9.348_404).abs() < 1e-5);
        let [low, high] = mean_interval(10_000, 3.0, 0.99);
        assert!(low > 2.93 && low < 3.0 && high > 3.0 && high < 3.07);
        assert!(mean_interval(0, 3.0, 0.95)[0].is_nan());
    }
}
