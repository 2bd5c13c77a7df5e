//! Whether errors are as large as an estimator reports: mean NEES and NIS with their
//! intervals. docs/metrics.md has source, departures and limits.

use rusty_contract::score::{Consistency, Verdict};

use super::batches::Batches;
use super::chi_square::{cdf, mean_interval};
use super::nees::GREATEST;

/// Normalised squares of one run.
#[derive(Clone, Debug)]
pub struct Samples {
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
    #[must_use]
    pub fn of_errors(level: f64) -> Self {
        Self { batches: Some(Batches::default()), ..Self::of_innovations(level) }
    }

    /// Of innovations, each of which is new.
    #[must_use]
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
    #[must_use]
    pub fn consistency(&self) -> Option<Consistency> {
        let count = self.count as f64;
        let effective = self.batches.as_ref().map_or(count, Batches::effective);
        let mean = self.sum / count;
        if self.count == 0 || !mean.is_finite() {
            return None;
        }
        let interval = mean_interval(effective, self.degrees / count, self.level);
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
