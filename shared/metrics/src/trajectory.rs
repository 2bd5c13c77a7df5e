//! Trajectory errors as the ticks go by: absolute (ATE) from a common origin, relative
//! (RPE) per tick and per metre.
//!
//! Source: M. Grupp, *evo* (Python package, 1.38.1): `evo_ape --align_origin` and
//! `evo_rpe` with `--delta 1 --delta_unit f` and `--delta 1 --delta_unit m`, for
//! `trans_part` and `angle_rad`. A step per metre follows the *estimate*'s path.

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
    /// Where the step under way began, and how far the estimate has come since.
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
        let step_m = scored.estimate.translation() - last.estimate.translation();
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
