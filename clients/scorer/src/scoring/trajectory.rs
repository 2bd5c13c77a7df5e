//! Trajectory errors as the ticks go by: absolute (ATE) without alignment and
//! from a common origin, relative (RPE) per tick and per metre.
//!
//! Source: M. Grupp, *evo* (Python package, 1.38.1): `evo_ape` and `evo_rpe` for
//! `trans_part` and `angle_rad`. The absolute error of a pose is ref⁻¹ est; from
//! a common origin (`--align_origin`) est is moved by ref₀ est₀⁻¹ from the left.
//! The relative error of a pair is E = (ref_i⁻¹ ref_j)⁻¹ (est_i⁻¹ est_j); pairs
//! are each scored tick with the next (`--delta 1 --delta_unit f`), and
//! (`--delta 1 --delta_unit m`) each pose with the first at which the straight
//! steps of the *estimate*'s path since then come to a metre or more, which is
//! where the next pair begins. Its tolerance (`--delta_tol`) is for `--all_pairs`
//! alone. J. Sturm et al., *A benchmark for the evaluation of RGB-D SLAM systems*
//! (IROS 2012), is where both errors come from.

use rusty_contract::score::{
    AbsoluteErrors, Errors, PoseErrors, RelativeErrors, heading_error_rad, position_error_m,
};
use rusty_geometry::{SE2, trig};

use super::scored::Scored;
use super::statistics::{Moments, PoseRow, Row};

/// A step of the relative error per metre, m.
pub(super) const METRE: f64 = 1.0;

/// The absolute errors that need to see each tick once.
#[derive(Clone, Debug)]
pub(super) struct Absolute {
    /// The median of the translation is that of [`Errors`].
    translation_m: Moments,
    rotation_rad: Row,
    /// What puts the first estimate on the first truth.
    to_origin: Option<SE2>,
    from_origin: PoseRow,
}

impl Absolute {
    /// No tick yet, with room for as many as are expected.
    pub fn expecting(ticks: u64) -> Self {
        Self {
            translation_m: Moments::default(),
            rotation_rad: Row::expecting(ticks),
            to_origin: None,
            from_origin: PoseRow::expecting(ticks),
        }
    }

    pub fn push(&mut self, scored: &Scored) {
        self.translation_m.push(scored.position_error_m());
        self.rotation_rad.push(scored.heading_error_rad().abs());
        let Scored { truth, estimate, .. } = scored;
        let to_origin = *self.to_origin.get_or_insert_with(|| *truth * estimate.inverse());
        let (error_m, error_rad) = absolute_error(&(to_origin * *estimate), truth);
        self.from_origin.push(error_m, error_rad);
    }

    /// What they come to; `errors` have taken the same ticks.
    pub fn errors(&mut self, errors: &mut Errors) -> AbsoluteErrors {
        let mut none = || {
            Some(PoseErrors {
                translation_m: self.translation_m.statistics(errors.median_m())?,
                rotation_rad: self.rotation_rad.statistics()?,
            })
        };
        AbsoluteErrors { none: none(), origin: self.from_origin.errors(), se2: None }
    }
}

/// Length, m, and angle, rad 0 to π, of truth⁻¹ ∘ estimate.
pub(super) fn absolute_error(estimate: &SE2, truth: &SE2) -> (f64, f64) {
    (position_error_m(estimate, truth), heading_error_rad(estimate, truth).abs())
}

/// The relative errors.
#[derive(Clone, Debug)]
pub(super) struct Relative {
    last: Option<Scored>,
    per_tick: PoseRow,
    /// Where the step under way began, and how far the estimate has come since.
    begin: Option<Scored>,
    path_m: f64,
    per_metre: PoseRow,
}

impl Relative {
    /// No tick yet, with room for as many as are expected.
    pub fn expecting(ticks: u64) -> Self {
        Self {
            last: None,
            per_tick: PoseRow::expecting(ticks),
            begin: None,
            path_m: 0.0,
            per_metre: PoseRow::expecting(ticks),
        }
    }

    /// Takes the next scored tick; says the error of the step to it, m and rad.
    pub fn push(&mut self, scored: &Scored) -> Option<(f64, f64)> {
        let last = self.last.replace(*scored);
        let begin = *self.begin.get_or_insert(*scored);
        let last = last?;
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
        Some((error_m, error_rad))
    }

    pub fn errors(&mut self) -> RelativeErrors {
        RelativeErrors { per_tick: self.per_tick.errors(), per_metre: self.per_metre.errors() }
    }
}

/// What the motion from one scored tick to another was believed wrong by,
/// (m, rad): E = (r_i⁻¹ r_j)⁻¹ (e_i⁻¹ e_j) for truths r and estimates e.
pub(super) fn relative_error(i: &Scored, j: &Scored) -> (f64, f64) {
    let true_motion = i.truth.inverse() * j.truth;
    let believed_motion = i.estimate.inverse() * j.estimate;
    let error = true_motion.inverse() * believed_motion;
    (trig::hypot(error.x(), error.y()), error.theta().abs())
}
