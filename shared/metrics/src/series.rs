//! Errors that come one by one, with the figures that *evo* makes of them.

use rusty_contract::score::{PoseErrors, Statistics};

use super::moments::Running;
use super::quantiles::Quantiles;

/// Up to this count medians are exact; see [`Quantiles`] for beyond.
pub(super) const EXACT_MEDIANS: usize = 1 << 17;

/// Numbers that are not negative: their moments and their percentiles.
#[derive(Clone, Debug)]
pub struct Series {
    moments: Running,
    sorted: Quantiles,
}

impl Series {
    /// No value yet, with room for this number of values; at most `most_kept` are kept
    /// for exact percentiles.
    #[must_use]
    pub fn keeping(most_kept: usize, count: u64) -> Self {
        Self { moments: Running::default(), sorted: Quantiles::keeping(most_kept, count) }
    }

    /// Takes the next value.
    pub fn push(&mut self, value: f64) {
        self.moments.push(value);
        self.sorted.push(value);
    }

    /// Forgets all values, but keeps the memory.
    pub fn clear(&mut self) {
        self.moments = Running::default();
        self.sorted.clear();
    }

    /// All but the percentiles.
    #[must_use]
    pub fn moments(&self) -> &Running {
        &self.moments
    }

    /// The percentile at `fraction`; `None` without a value.
    pub fn at(&mut self, fraction: f64) -> Option<f64> {
        self.sorted.at(fraction)
    }

    /// The figures of evo; `None` without a value, or where one is not finite.
    pub fn statistics(&mut self) -> Option<Statistics> {
        self.moments.statistics(self.sorted.at(0.5))
    }
}

/// The errors of poses: translation, m, and rotation, rad.
#[derive(Clone, Debug)]
pub struct PoseSeries {
    translation_m: Series,
    rotation_rad: Series,
}

impl PoseSeries {
    /// No pose yet, with room for this number of poses.
    #[must_use]
    pub fn expecting(count: u64) -> Self {
        let series = || Series::keeping(EXACT_MEDIANS, count);
        Self { translation_m: series(), rotation_rad: series() }
    }

    /// Takes the next pose's; neither is negative.
    pub fn push(&mut self, translation_m: f64, rotation_rad: f64) {
        self.translation_m.push(translation_m);
        self.rotation_rad.push(rotation_rad);
    }

    /// The figures of evo; `None` without a pose, or where one is not finite.
    pub fn errors(&mut self) -> Option<PoseErrors> {
        let translation_m = self.translation_m.statistics()?;
        Some(PoseErrors { translation_m, rotation_rad: self.rotation_rad.statistics()? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        let mut series = Series::keeping(9, 4);
        assert_eq!(series.statistics(), None);
        [1.0, 4.0, 2.0, 5.0].into_iter().for_each(|v| series.push(v));
        let found = series.statistics().unwrap();
        assert_eq!((found.count, found.min, found.max, found.sse), (4, 1.0, 5.0, 46.0));
        assert_eq!((found.mean, found.median), (3.0, 3.0));
        assert!((found.std - 2.5f64.sqrt()).abs() < 1e-15, "divided by the count");
        assert_eq!(found.rmse, 11.5f64.sqrt());
    }

    #[test]
    fn errors_that_are_large_and_alike_keep_their_spread() {
        let mut series = Series::keeping(1000, 0);
        (0..1000).for_each(|k| series.push(1e6 + f64::from(k % 2) * 1e-3));
        let std = series.statistics().unwrap().std;
        assert!((std - 0.5e-3).abs() < 1e-9, "{std}");
    }

    #[test]
    fn what_has_no_square_has_no_figures() {
        let mut series = PoseSeries::expecting(0);
        series.push(1e200, 0.1);
        assert_eq!(series.errors(), None);
    }
}
