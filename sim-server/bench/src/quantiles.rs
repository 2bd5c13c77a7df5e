//! What a list of durations comes to.

use rusty_metrics::percentile;
use serde::{Deserialize, Serialize};

/// Quantiles of durations, ns. They are exact: each is one of the durations,
/// the smallest that this share of them does not exceed (nearest rank).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quantiles {
    /// How many durations.
    pub count: usize,
    /// Arithmetic mean.
    pub mean_ns: f64,
    /// Half are not longer.
    pub p50_ns: u64,
    /// 90 % are not longer.
    pub p90_ns: u64,
    /// 99 % are not longer.
    pub p99_ns: u64,
    /// 99.9 % are not longer.
    pub p99_9_ns: u64,
    /// The longest.
    pub max_ns: u64,
}

impl Quantiles {
    /// Of these durations, ns, which are sorted in place. Of none: zeros.
    #[must_use]
    pub fn of(durations_ns: &mut [u64]) -> Self {
        durations_ns.sort_unstable();
        let Some(&max_ns) = durations_ns.last() else { return Self::default() };
        let rank = |per_mille| nearest_rank(durations_ns, per_mille);
        let sum: f64 = durations_ns.iter().map(|&d| d as f64).sum();
        Self {
            count: durations_ns.len(),
            mean_ns: sum / durations_ns.len() as f64,
            p50_ns: rank(500),
            p90_ns: rank(900),
            p99_ns: rank(990),
            p99_9_ns: rank(999),
            max_ns,
        }
    }
}

/// The smallest of `sorted` that `per_mille` of them do not exceed; `sorted`
/// has at least one.
fn nearest_rank(sorted: &[u64], per_mille: usize) -> u64 {
    let rank = (sorted.len() * per_mille).div_ceil(1000);
    sorted[rank.saturating_sub(1).min(sorted.len() - 1)]
}

/// A number measured in several repetitions: its median, and how far apart
/// they were.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// The middle one; of an even number, the mean of the middle two.
    pub median: f64,
    /// The smallest.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

impl Spread {
    /// Of these numbers. Of none: zeros.
    #[must_use]
    pub fn of(numbers: impl IntoIterator<Item = f64>) -> Self {
        let mut all: Vec<f64> = numbers.into_iter().collect();
        let [min, median, max] =
            [0.0, 0.5, 1.0].map(|at| percentile(&mut all, at).unwrap_or_default());
        Self { median, min, max }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_thousand_durations_each_quantile_is_one_of_them() {
        let mut durations: Vec<u64> = (1..=1000).rev().collect();
        let q = Quantiles::of(&mut durations);
        assert_eq!(
            (q.p50_ns, q.p90_ns, q.p99_ns, q.p99_9_ns, q.max_ns),
            (500, 900, 990, 999, 1000)
        );
        assert_eq!((q.count, q.mean_ns), (1000, 500.5));
    }

    #[test]
    fn of_few_durations_the_far_quantiles_are_the_longest() {
        let q = Quantiles::of(&mut [7, 3, 5]);
        assert_eq!((q.p50_ns, q.p90_ns, q.p99_9_ns, q.max_ns), (5, 7, 7, 7));
        assert_eq!(Quantiles::of(&mut []), Quantiles::default());
    }

    #[test]
    fn a_spread_has_its_median_in_the_middle() {
        assert_eq!(Spread::of([3.0, 1.0, 2.0]), Spread { median: 2.0, min: 1.0, max: 3.0 });
        assert_eq!(Spread::of([4.0, 1.0]).median, 2.5);
        assert_eq!(Spread::of([]), Spread::default());
    }
}
