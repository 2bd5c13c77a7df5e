//! The number of independent samples that a row of dependent ones is worth, in memory
//! of a fixed size: batch means with a correction for the correlation of neighbouring
//! means. docs/metrics.md has the sources and a table of how often verdicts are right.
//!
//! The row is cut into batches of equal length b. If the batches' means scatter with
//! variance S² and the numbers with s², then b S²/s² numbers are worth an independent
//! one. Departures: batches are n/64 to n/32 long, not √n; and the count is divided by
//! (1 + ρ)/(1 − ρ), with ρ the correlation of neighbouring means, at least 0.

use super::moments::Running;

const MOST: usize = 64;
/// Of fewer numbers it is unknown how they depend on each other.
const FEWEST: u64 = 16;

/// A row of numbers, in batches.
#[derive(Clone, Debug)]
pub struct Batches {
    all: Running,
    /// Sums of the batches that are full.
    sums: [f64; MOST],
    full: usize,
    /// Numbers to a batch.
    length: u64,
    /// The batch that is being filled.
    sum: f64,
    count: u64,
}

impl Default for Batches {
    fn default() -> Self {
        let all = Running::default();
        Self { all, sums: [0.0; MOST], full: 0, length: 1, sum: 0.0, count: 0 }
    }
}

impl Batches {
    /// Takes the next number.
    pub fn push(&mut self, value: f64) {
        self.all.push(value);
        if self.full == MOST {
            for pair in 0..MOST / 2 {
                self.sums[pair] = self.sums[2 * pair] + self.sums[2 * pair + 1];
            }
            self.full = MOST / 2;
            self.length *= 2;
        }
        self.sum += value;
        self.count += 1;
        if self.count == self.length {
            self.sums[self.full] = self.sum;
            self.full += 1;
            (self.sum, self.count) = (0.0, 0);
        }
    }

    /// As many independent numbers would have as uncertain a mean: between 1 and
    /// their count. Fewer than 16 count as one.
    #[must_use]
    pub fn effective(&self) -> f64 {
        let count = self.all.count() as f64;
        if self.all.count() < FEWEST {
            return count.min(1.0);
        }
        let mut means = Running::default();
        self.means().for_each(|mean| means.push(mean));
        let batches = self.full as f64;
        let spread = means.variance() * batches / (batches - 1.0);
        let each_worth = self.length as f64 * spread / self.all.variance() * self.persistence();
        // Numbers that are all the same say nothing of how they scatter.
        if each_worth.is_finite() { (count / each_worth).clamp(1.0, count) } else { 1.0 }
    }

    fn means(&self) -> impl Iterator<Item = f64> {
        self.sums[..self.full].iter().map(|sum| sum / self.length as f64)
    }

    /// (1 + ρ)/(1 − ρ) of the batches' means.
    fn persistence(&self) -> f64 {
        let batches = self.full as f64;
        let mean = self.means().sum::<f64>() / batches;
        let from_mean = |value: f64| value - mean;
        let squares: f64 = self.means().map(|m| from_mean(m) * from_mean(m)).sum();
        let products: f64 =
            self.means().zip(self.means().skip(1)).map(|(a, b)| from_mean(a) * from_mean(b)).sum();
        let rho = (products / squares * batches + 1.0) / (batches - 4.0);
        // Means that are all the same do not follow each other.
        let rho = if rho.is_finite() { rho.clamp(0.0, 0.999) } else { 0.0 };
        (1.0 + rho) / (1.0 - rho)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: impl Iterator<Item = f64>) -> Batches {
        let mut batches = Batches::default();
        values.for_each(|v| batches.push(v));
        batches
    }

    #[test]
    fn batches_are_of_equal_length_and_between_32_and_64() {
        for count in 1..3000u64 {
            let batches = of((0..count).map(|k| k as f64));
            assert!(batches.full <= MOST && (count < 32 || batches.full >= 32), "{count}");
            assert_eq!(batches.full as u64, count / batches.length);
            for (k, mean) in batches.means().enumerate() {
                let first = (k as u64 * batches.length) as f64;
                assert_eq!(mean, first + 0.5 * (batches.length - 1) as f64, "{count}");
            }
        }
    }

    #[test]
    fn the_count_is_bounded_and_what_never_changes_counts_once() {
        assert_eq!(of([].into_iter()).effective(), 0.0);
        for count in 1..200 {
            let n = f64::from(count);
            assert_eq!(of((0..count).map(|_| 0.1)).effective(), 1.0);
            let flipping = of((0..count).map(|k| f64::from(k % 2))).effective();
            assert!((1.0..=n).contains(&flipping), "{count}: {flipping}");
            let rising = of((0..count).map(f64::from)).effective();
            assert!((1.0..1.5).contains(&rising), "{count}: {rising}");
        }
        assert_eq!(of((0..1000).map(|k| f64::from(k % 2))).effective(), 1000.0);
    }
}
