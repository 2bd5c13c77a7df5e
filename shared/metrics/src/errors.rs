//! The errors of one estimator, tick by tick, and the figures of a score.
//!
//! Source: M. Grupp, *evo* (Python package, 1.38.1), `evo_ape` without alignment, for
//! planar poses.

use rusty_contract::score::{Figures, PoseErrors};
use rusty_geometry::SE2;

use super::quantiles::MOST_KEPT;
use super::scored::{heading_error_rad, position_error_m};
use super::series::{EXACT_MEDIANS, Series};

/// Errors, tick by tick. Cleared, it serves the next run without allocating.
#[derive(Clone, Debug)]
pub struct Errors {
    position_m: Series,
    heading_rad: Series,
    last: [f64; 2],
}

impl Default for Errors {
    fn default() -> Self {
        Self::expecting(0)
    }
}

impl Errors {
    /// No tick yet, with room for this number of ticks.
    #[must_use]
    pub fn expecting(ticks: u64) -> Self {
        let position_m = Series::keeping(MOST_KEPT, ticks);
        Self { position_m, heading_rad: Series::keeping(EXACT_MEDIANS, ticks), last: [0.0; 2] }
    }

    /// Takes the next tick: an estimate and its truth, both made of finite numbers.
    /// Returns position error, m, and heading error, rad, 0 to π.
    pub fn push(&mut self, estimate: &SE2, truth: &SE2) -> [f64; 2] {
        let position_m = position_error_m(estimate, truth);
        let heading_rad = heading_error_rad(estimate, truth).abs();
        self.position_m.push(position_m);
        self.heading_rad.push(heading_rad);
        self.last = [position_m, heading_rad];
        self.last
    }

    /// Ticks taken.
    #[must_use]
    pub fn tick_count(&self) -> u64 {
        self.position_m.moments().count()
    }

    /// Forgets all ticks, but keeps the memory.
    pub fn clear(&mut self) {
        self.position_m.clear();
        self.heading_rad.clear();
    }

    /// The figures of the ticks up to now; more may follow.
    pub fn figures(&mut self) -> Figures {
        let p95_position_error_m = self.position_m.at(0.95);
        let (position_m, heading_rad) = (self.position_m.moments(), self.heading_rad.moments());
        let some = |value: f64| (self.tick_count() > 0).then_some(value);
        Figures {
            final_position_error_m: some(self.last[0]),
            final_heading_error_rad: some(self.last[1]),
            mean_position_error_m: some(position_m.mean()),
            p95_position_error_m,
            max_position_error_m: some(position_m.greatest()),
            ate_rmse_m: some(position_m.rms()),
            rmse_heading_error_rad: some(heading_rad.rms()),
            max_heading_error_rad: some(heading_rad.greatest()),
        }
    }

    /// The figures of evo; `None` without a tick, or where one is not finite.
    pub fn pose_errors(&mut self) -> Option<PoseErrors> {
        let translation_m = self.position_m.statistics()?;
        Some(PoseErrors { translation_m, rotation_rad: self.heading_rad.statistics()? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand_and_once_more_after_clearing() {
        let truth = SE2::new(0.0, 0.0, 3.0);
        let mut errors = Errors::default();
        assert_eq!(errors.figures(), Figures::default());
        for _ in 0..2 {
            errors.clear();
            errors.push(&SE2::new(3.0, 4.0, -3.0), &truth);
            errors.push(&SE2::new(0.0, 1.0, 3.0), &truth);
            let figures = errors.figures();
            assert_eq!(figures.final_position_error_m, Some(1.0));
            assert_eq!(figures.final_heading_error_rad, Some(0.0));
            assert_eq!(
                (figures.mean_position_error_m, figures.max_position_error_m),
                (Some(3.0), Some(5.0))
            );
            assert_eq!(figures.ate_rmse_m, Some(13f64.sqrt()));
            // Across the half turn: 2π − 6, not 6.
            let turn_rad = std::f64::consts::TAU - 6.0;
            assert!((figures.max_heading_error_rad.unwrap() - turn_rad).abs() < 1e-15);
        }
    }
}
