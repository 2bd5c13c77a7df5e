//! Rows of errors that come one by one, and the figures that *evo* makes of
//! them.
//!
//! Source: `evo.core.metrics.PE.get_statistic` of evo 1.38.1. The mean square
//! deviation is summed as in B. P. Welford, *Note on a method for calculating
//! corrected sums of squares and products*, Technometrics 4 (1962), which loses
//! no digits where errors are large and alike.

use rusty_contract::score::{PoseErrors, Quantiles, Statistics};

/// Up to so many numbers their median is exact; see [`Quantiles`] for beyond.
pub(super) const EXACT_MEDIANS: usize = 1 << 17;

/// All of the figures but the median.
#[derive(Clone, Debug, Default)]
pub(super) struct Moments {
    count: u64,
    sum: f64,
    squares: f64,
    mean: f64,
    deviation2: f64,
    least: f64,
    greatest: f64,
}

impl Moments {
    /// Takes the next value.
    pub fn push(&mut self, value: f64) {
        if self.count == 0 {
            (self.least, self.greatest) = (value, value);
        }
        self.count += 1;
        self.sum += value;
        self.squares += value * value;
        let from_mean = value - self.mean;
        self.mean += from_mean / self.count as f64;
        self.deviation2 += from_mean * (value - self.mean);
        self.least = self.least.min(value);
        self.greatest = self.greatest.max(value);
    }

    /// How many there were.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Variance, divided by the count; 0 without a value.
    pub fn variance(&self) -> f64 {
        if self.count == 0 { 0.0 } else { self.deviation2 / self.count as f64 }
    }

    /// The figures, with a median from elsewhere. `None` without a value, and
    /// where one is no number that can be written down: an estimate that is
    /// 10²⁰⁰ m off has no square.
    pub fn statistics(&self, median: Option<f64>) -> Option<Statistics> {
        let count = self.count as f64;
        let found = Statistics {
            count: self.count,
            rmse: (self.squares / count).sqrt(),
            mean: self.sum / count,
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

/// All of the figures.
#[derive(Clone, Debug)]
pub(super) struct Row {
    moments: Moments,
    sorted: Quantiles,
}

impl Row {
    /// No value yet, with room for as many as are expected.
    pub fn expecting(count: u64) -> Self {
        Self { moments: Moments::default(), sorted: Quantiles::keeping(EXACT_MEDIANS, count) }
    }

    /// Takes the next value, which is not negative.
    pub fn push(&mut self, value: f64) {
        self.moments.push(value);
        self.sorted.push(value);
    }

    pub fn statistics(&mut self) -> Option<Statistics> {
        self.moments.statistics(self.sorted.at(0.5))
    }
}

/// The errors of poses: translation, m, and rotation, rad.
#[derive(Clone, Debug)]
pub(super) struct PoseRow {
    translation_m: Row,
    rotation_rad: Row,
}

impl PoseRow {
    pub fn expecting(count: u64) -> Self {
        Self { translation_m: Row::expecting(count), rotation_rad: Row::expecting(count) }
    }

    /// Takes the next pose's; neither is negative.
    pub fn push(&mut self, translation_m: f64, rotation_rad: f64) {
        self.translation_m.push(translation_m);
        self.rotation_rad.push(rotation_rad);
    }

    pub fn errors(&mut self) -> Option<PoseErrors> {
        Some(PoseErrors {
            translation_m: self.translation_m.statistics()?,
            rotation_rad: self.rotation_rad.statistics()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        let mut row = Row::expecting(4);
        assert_eq!(row.statistics(), None);
        [1.0, 4.0, 2.0, 5.0].into_iter().for_each(|v| row.push(v));
        let found = row.statistics().unwrap();
        assert_eq!((found.count, found.min, found.max, found.sse), (4, 1.0, 5.0, 46.0));
        assert_eq!((found.mean, found.median), (3.0, 3.0));
        assert!((found.std - 2.5f64.sqrt()).abs() < 1e-15, "divided by the count");
        assert_eq!(found.rmse, 11.5f64.sqrt());
    }

    #[test]
    fn errors_that_are_large_and_alike_keep_their_spread() {
        let mut row = Row::expecting(0);
        (0..1000).for_each(|k| row.push(1e6 + f64::from(k % 2) * 1e-3));
        let std = row.statistics().unwrap().std;
        assert!((std - 0.5e-3).abs() < 1e-9, "{std}");
    }

    #[test]
    fn what_has_no_square_has_no_figures() {
        let mut row = PoseRow::expecting(0);
        row.push(1e200, 0.1);
        assert_eq!(row.errors(), None);
    }
}
