//! The sign test: who is smaller more often, whatever the differences are like.
//!
//! Source: J. Arbuthnott (1710), in the form of W. Dixon and A. Mood (*The
//! Statistical Sign Test*, JASA 41, 1946): if neither is better, each difference
//! that is not zero has either sign with probability ½, so how many have one is
//! binomial. Ties say nothing and are left out. The probability is exact, and
//! two-sided: both tails, once over. At most k of n: I_½(n − k, k + 1) (M.
//! Abramowitz and I. Stegun, *Handbook of Mathematical Functions*, 26.5.24).

use serde::Serialize;
use statrs::function::beta::beta_reg;

/// Signs of differences.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct SignTest {
    /// Differences below zero.
    pub below: u64,
    /// Differences above zero.
    pub above: u64,
    /// Differences of zero.
    pub ties: u64,
}

impl SignTest {
    /// The signs of `differences`.
    #[must_use]
    pub fn of(differences: &[f64]) -> Self {
        let count = |is: fn(&f64) -> bool| differences.iter().filter(|d| is(d)).count() as u64;
        Self { below: count(|d| *d < 0.0), above: count(|d| *d > 0.0), ties: count(|d| *d == 0.0) }
    }

    /// How likely signs as uneven as these, or more, are if either is as likely
    /// as the other; 1 where all are ties.
    #[must_use]
    pub fn p_value(&self) -> f64 {
        let fewer = self.below.min(self.above);
        let more = self.below.max(self.above);
        if more == 0 {
            return 1.0;
        }
        let tail = beta_reg(more as f64, fewer as f64 + 1.0, 0.5);
        (2.0 * tail).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn p(below: u64, above: u64) -> f64 {
        SignTest { below, above, ties: 7 }.p_value()
    }

    #[test]
    fn by_hand() {
        let signs = SignTest::of(&[-1.0, 2.0, 0.0, 3.0, -0.0, f64::NAN]);
        assert_eq!(signs, SignTest { below: 1, above: 2, ties: 2 });
        // 2 (1 + 10) / 2¹⁰ and 2 / 2⁵.
        assert!((p(9, 1) - 22.0 / 1024.0).abs() < 1e-14);
        assert!((p(0, 5) - 1.0 / 16.0).abs() < 1e-14);
        assert_eq!((p(0, 0), p(4, 4)), (1.0, 1.0));
        assert!((p(1, 2) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn small_tails_keep_their_digits() {
        // The sum of binomial coefficients up to 13 of 100, over 2⁹⁹.
        let mut term = 1.0_f64;
        let mut sum = 1.0;
        for k in 1..=13 {
            term *= (101.0 - f64::from(k)) / f64::from(k);
            sum += term;
        }
        let expected = sum / (1u128 << 99) as f64;
        assert!((p(87, 13) / expected - 1.0).abs() < 1e-9, "{:e} {expected:e}", p(87, 13));
        assert!(p(500, 0) > 0.0 && p(500, 0) < 1e-149);
        assert_eq!(p(13, 87), p(87, 13));
    }
}
