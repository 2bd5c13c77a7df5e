//! Whether errors are as large as an estimator says they are.
//!
//! Source: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications
//! to Tracking and Navigation* (Wiley, 2001), §5.4: the normalised estimation
//! error squared (NEES), ε = τᵀ P⁻¹ τ, and the normalised innovation squared
//! (NIS) are χ² if error and covariance, innovation and its covariance, belong
//! together; so the mean of n independent ones with d degrees each is χ² with
//! n·d degrees, over n.
//!
//! Departures: the error is not a difference of numbers but τ = truth ⊟
//! estimate, in the tangent space at the estimate, where
//! [`Estimate::covariance`](rusty_contract::Estimate::covariance) is defined: no
//! angle jumps at ±π, and a covariance that lies along the robot's heading stays
//! with it. The book averages over runs; one run's errors depend on each other,
//! so here n is what [`Batches`] say they are worth. Innovations of a filter
//! that is right are independent, and all of them count.

use rusty_contract::score::chi_square::{band, cdf};
use rusty_contract::score::nees::GREATEST;
pub(super) use rusty_contract::score::nees::nees;
use rusty_contract::score::{Consistency, Verdict};

use super::batches::Batches;

/// Normalised squares of one run.
#[derive(Clone, Debug)]
pub(super) struct Samples {
    level: f64,
    /// How the samples depend on each other; `None`: not at all.
    batches: Option<Batches>,
    count: u64,
    unusable: u64,
    degrees: f64,
    sum: f64,
    last: f64,
    last_degrees: f64,
    within: u64,
}

impl Samples {
    /// Of errors, which drag on from tick to tick.
    pub fn of_errors(level: f64) -> Self {
        Self { batches: Some(Batches::default()), ..Self::of_innovations(level) }
    }

    /// Of innovations, each of which is new.
    pub fn of_innovations(level: f64) -> Self {
        Self {
            level,
            batches: None,
            count: 0,
            unusable: 0,
            degrees: 0.0,
            sum: 0.0,
            last: 0.0,
            last_degrees: 0.0,
            within: 0,
        }
    }

    /// Takes the next one; `None` could not be made.
    pub fn push(&mut self, value: Option<f64>, degrees: u32) {
        let usable = value.filter(|v| (0.0..=GREATEST).contains(v) && degrees > 0);
        let Some(value) = usable else {
            self.unusable += 1;
            return;
        };
        let degrees = f64::from(degrees);
        if let Some(batches) = &mut self.batches {
            batches.push(value);
        }
        self.count += 1;
        self.degrees += degrees;
        self.sum += value;
        (self.last, self.last_degrees) = (value, degrees);
        let (below, tail) = (cdf(value, degrees), 0.5 * (1.0 - self.level));
        self.within += u64::from((tail..=1.0 - tail).contains(&below));
    }

    /// What they say; `None` where there is no sample.
    pub fn consistency(&self) -> Option<Consistency> {
        let count = self.count as f64;
        let effective = self.batches.as_ref().map_or(count, Batches::effective);
        let mean = self.sum / count;
        if self.count == 0 || !mean.is_finite() {
            return None;
        }
        let band = band(self.level, self.degrees / count * effective);
        let interval = band.map(|sum| sum / effective);
        Some(Consistency {
            samples: self.count,
            unusable: self.unusable,
            degrees: self.degrees,
            sum: self.sum,
            mean,
            last: self.last,
            last_degrees: self.last_degrees,
            share_within: self.within as f64 / count,
            effective_samples: effective,
            interval,
            level: self.level,
            verdict: Verdict::of(mean, interval),
        })
    }
}

#[cfg(test)]
#[path = "consistency_tests.rs"]
mod tests;
