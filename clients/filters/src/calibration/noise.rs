//! The noise of wheels, learned: the factors by which the variances of their turns and of
//! their distances are greater than given.
//!
//! Source: the estimation of variance components (K.-R. Koch, *Parameter Estimation and
//! Hypothesis Testing in Linear Models*, Springer 1999, §3.6). A residual e with the
//! covariance S = Σ σₖ² Vₖ + … has the part σₖ² Vₖ S⁻¹ e in component k. Its square
//! e' S⁻¹ σₖ² Vₖ S⁻¹ e is tr(S⁻¹ σₖ² Vₖ) in the mean, if σₖ² is right.
//!
//! Departures: the book repeats the estimate with all residuals until it stays; here each
//! motion counts once, with the factors before it. A motion that surprises counts less. No
//! factor is below 1.

use nalgebra::{Matrix3, Vector3};

use crate::OdometryNoise;

/// Variance of the distance per distance of wheels of which nothing is known, m²/m: 3 cm in
/// a metre. The default is 1e-5; `fit-motion` finds 2.4e-3 on Intel.
const UNKNOWN_ALPHA3: f64 = 1e-3;
/// Upper limit of the factor that they begin with: it also applies to α₄.
const MOST_UNKNOWN: f64 = 1000.0;
/// Number of measured values that the factors at the start are worth. From 1 to 10 the
/// recordings look the same; a smaller number learns good wheels sooner.
const START_DEGREES: f64 = 10.0;

/// A factor: the sum of squares found, over the number of squares expected.
#[derive(Clone, Copy, Debug)]
struct Factor {
    squares: f64,
    degrees: f64,
}

impl Factor {
    fn new(factor: f64) -> Self {
        Self { squares: START_DEGREES * factor, degrees: START_DEGREES }
    }

    fn value(&self) -> f64 {
        (self.squares / self.degrees).max(1.0)
    }
}

/// The factors of turns and of distances.
#[derive(Clone, Copy, Debug)]
pub(super) struct NoiseFactors([Factor; 2]);

impl NoiseFactors {
    /// Begins with turns and distances as noisy as given.
    pub(super) fn given() -> Self {
        Self([Factor::new(1.0); 2])
    }

    /// Begins with turns as noisy as given, and distances as noisy as those of an unknown robot.
    pub(super) fn unknown(given: &OdometryNoise) -> Self {
        let distances = if given.alpha3 > 0.0 { UNKNOWN_ALPHA3 / given.alpha3 } else { 1.0 };
        Self([1.0, distances.clamp(1.0, MOST_UNKNOWN)].map(Factor::new))
    }

    /// The covariance of turns and distances together, from those of both as noisy as given.
    pub(super) fn sum(&self, [turns, distances]: &[Matrix3<f64>; 2]) -> Matrix3<f64> {
        let [of_turns, of_distances] = self.0.map(|factor| factor.value());
        turns * of_turns + distances * of_distances
    }

    /// Learns from a residual with this inverse covariance S⁻¹, in which turns and distances
    /// as noisy as given have these covariances. Its square is divided by `surprising`.
    pub(super) fn learn(
        &mut self,
        given: &[Matrix3<f64>; 2],
        inverse: &Matrix3<f64>,
        residual: &Vector3<f64>,
        surprising: f64,
    ) {
        let weighted = inverse * residual;
        for (factor, given) in self.0.iter_mut().zip(given) {
            let value = factor.value();
            let part = given * value;
            let squares = (weighted.transpose() * part * weighted).x / surprising;
            let expected = (inverse * part).trace();
            if squares.is_finite() && expected.is_finite() {
                factor.squares += squares * value;
                factor.degrees += expected;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    /// The factors after motions with these variances, (turns, distances), where 1 is given
    /// and all is measured with a variance of 1, and the standard α₃.
    fn learned(truth: [f64; 2], motions: u32) -> [f64; 2] {
        let given = OdometryNoise::default();
        let mut noise = NoiseFactors::unknown(&given);
        let (mut random, mut factors) = (Random::new(5, 1), [0.0; 2]);
        let diagonal = |x, z| Matrix3::from_diagonal(&Vector3::new(x, 0.0, z));
        let parts = [diagonal(0.0, 1.0), diagonal(1.0, 0.0)];
        for _ in 0..motions {
            let [turn, distance] = truth.map(|variance| (variance + 1.0).sqrt() * random.normal());
            let s = noise.sum(&parts) + Matrix3::identity();
            let residual = Vector3::new(distance, 0.0, turn);
            noise.learn(&parts, &s.try_inverse().unwrap(), &residual, 1.0);
            factors = noise.0.map(|factor| factor.value());
        }
        factors
    }

    #[test]
    fn the_variances_of_turns_and_distances_are_found() {
        for truth in [[4.0, 100.0], [30.0, 2000.0], [3.0, 8.0]] {
            let found = learned(truth, 2000);
            for (found, truth) in found.iter().zip(truth) {
                assert!((found / truth - 1.0).abs() < 0.15, "{found} for {truth}");
            }
        }
    }

    #[test]
    fn distances_begin_unknown_and_become_what_they_are_given_as() {
        let given = OdometryNoise::default();
        let begin = NoiseFactors::unknown(&given).0.map(|factor| factor.value());
        assert_eq!(begin, [1.0, UNKNOWN_ALPHA3 / given.alpha3]);
        // The factor stays 1 where the noise is less than given.
        let found = learned([0.1, 0.1], 2000);
        assert!(found[0] == 1.0 && found[1] < 1.7, "{found:?}");
        let factors = [(0.0, 1.0), (2e-3, 1.0), (1e-9, MOST_UNKNOWN), (1e-312, MOST_UNKNOWN)];
        for (alpha3, factor) in factors {
            let given = OdometryNoise { alpha3, ..given };
            let begin = NoiseFactors::unknown(&given).0.map(|factor| factor.value());
            assert_eq!(begin, [1.0, factor], "{alpha3}");
        }
    }

    #[test]
    fn a_surprise_counts_less() {
        let given = [Matrix3::zeros(), Matrix3::identity()];
        let after = |surprising: f64| {
            let mut noise = NoiseFactors::unknown(&OdometryNoise::default());
            let s = noise.sum(&given) + Matrix3::identity();
            let residual = Vector3::new(90.0, 0.0, 0.0);
            noise.learn(&given, &s.try_inverse().unwrap(), &residual, surprising);
            noise.0[1]
        };
        let (all, part) = (after(1.0), after(8.0));
        let begin = START_DEGREES * UNKNOWN_ALPHA3 / OdometryNoise::default().alpha3;
        assert!(((all.squares - begin) / (part.squares - begin) - 8.0).abs() < 1e-9);
        assert_eq!(all.degrees, part.degrees);
    }
}
