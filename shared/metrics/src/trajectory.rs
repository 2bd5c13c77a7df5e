//! Trajectory errors as the ticks go by: absolute (ATE) from a common origin, relative
//! (RPE) per tick and per metre.
//!
//! Source: M. Grupp, *evo* (Python package, 1.38.1): `evo_ape --align_origin` and
//! `evo_rpe` with `--delta 1 --delta_unit f` and `--delta 1 --delta_unit m
//! --pairs_from_reference`, for `trans_part` and `angle_rad`. A step per metre follows the
//! true path: an estimator could make its own as long as it likes, by shaking.

use rusty_contract::score::{PoseErrors, RelativeErrors};
use rusty_geometry::{SE2, trig};

use super::scored::{Scored, heading_error_rad, position_error_m};
use super::series::PoseSeries;

/// A step of the relative error per metre, m.
pub(super) const METRE: f64 = 1.0;

/// The absolute error with the first estimate on the first truth.
#[derive(Clone, Debug)]
pub(super) struct FromOrigin {
    to_origin: Option<SE2>,
    errors: PoseSeries,
}

impl FromOrigin {
    /// No tick yet, with room for as many as are expected.
    pub fn expecting(ticks: u64) -> Self {
        Self { to_origin: None, errors: PoseSeries::expecting(ticks) }
    }

    pub fn push(&mut self, Scored { truth, estimate, .. }: &Scored) {
        let to_origin = *self.to_origin.get_or_insert_with(|| *truth * estimate.inverse());
        let moved = to_origin * *estimate;
        let heading_rad = heading_error_rad(&moved, truth).abs();
        self.errors.push(position_error_m(&moved, truth), heading_rad);
    }

    pub fn errors(&mut self) -> Option<PoseErrors> {
        self.errors.errors()
    }
}

/// The relative errors.
#[derive(Clone, Debug)]
pub(super) struct Relative {
    last: Option<Scored>,
    per_tick: PoseSeries,
    /// Where the step under way began, and how far the robot has come since.
    begin: Option<Scored>,
    path_m: f64,
    per_metre: PoseSeries,
}

impl Relative {
    /// No tick yet, with room for as many as are expected.
    pub fn expecting(ticks: u64) -> Self {
        Self {
            last: None,
            per_tick: PoseSeries::expecting(ticks),
            begin: None,
            path_m: 0.0,
            per_metre: PoseSeries::expecting(ticks),
        }
    }

    /// Takes the next scored tick.
    pub fn push(&mut self, scored: &Scored) {
        let last = self.last.replace(*scored);
        let begin = *self.begin.get_or_insert(*scored);
        let Some(last) = last else { return };
        let (error_m, error_rad) = relative_error(&last, scored);
        self.per_tick.push(error_m, error_rad);
        // As numpy takes a length: where a path is a metre to the last bit,
        // another way of rounding would end the step elsewhere.
        let step_m = scored.truth.translation() - last.truth.translation();
        self.path_m += (step_m.x * step_m.x + step_m.y * step_m.y).sqrt();
        if self.path_m >= METRE {
            let (error_m, error_rad) = relative_error(&begin, scored);
            self.per_metre.push(error_m, error_rad);
            self.begin = Some(*scored);
            self.path_m = 0.0;
        }
    }

    pub fn errors(&mut self) -> RelativeErrors {
        RelativeErrors { per_tick: self.per_tick.errors(), per_metre: self.per_metre.errors() }
    }
}

/// The error of the motion from one scored tick to another, (m, rad):
/// E = (r_i⁻¹ r_j)⁻¹ (e_i⁻¹ e_j) for truths r and estimates e.
#[must_use]
pub fn relative_error(i: &Scored, j: &Scored) -> (f64, f64) {
    let true_motion = i.truth.inverse() * j.truth;
    let believed_motion = i.estimate.inverse() * j.estimate;
    let error = true_motion.inverse() * believed_motion;
    (trig::hypot(error.x(), error.y()), error.theta().abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Odometry that is 5 % long, shaken by as much to the left and right in turns.
    fn of_shaken(by_m: f64) -> RelativeErrors {
        let mut relative = Relative::expecting(1000);
        for tick in 0..1000_u32 {
            let x_m = 0.01 * f64::from(tick);
            let y_m = if tick % 2 == 0 { by_m } else { -by_m };
            let estimate = SE2::new(1.05 * x_m, y_m, 0.0);
            let truth = SE2::new(x_m, 0.0, 0.0);
            relative.push(&Scored { tick: tick as usize, truth, estimate });
        }
        relative.errors()
    }

    #[test]
    fn who_shakes_walks_no_metre_more() {
        for by_m in [0.0, 0.27] {
            let found = of_shaken(by_m).per_metre.unwrap();
            assert_eq!(found.translation_m.count, 9);
            assert!(found.translation_m.rmse > 0.049, "{found:?}");
        }
    }
}
