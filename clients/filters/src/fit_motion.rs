//! α₁ to α₄ of the odometry motion model from a log with true poses, by maximum
//! likelihood.
//!
//! Source: the model is that of *Probabilistic Robotics*, §5.4, as [`crate::motion`]
//! has it: errors of ticks are independent, normal, and their covariance is linear
//! in the four α. Between two true poses (a *window*: one tick in a simulation,
//! some in a recording) they add up on the group, which keeps it linear:
//! S = Σ αⱼ Cⱼ, with Cⱼ that of αⱼ = 1 alone. The fit is Fisher's method of
//! scoring for such components of variance (S. R. Searle, G. Casella,
//! C. E. McCulloch, *Variance Components*, 1992, §6.6), standard errors are from
//! the observed information.
//!
//! Departures, and why:
//! * Fitted to is how far ahead and how far round a window came out, not how far
//!   sideways: the model has the two turns of a tick independent, and a robot whose
//!   tick is an arc has them equal. What it says of ahead and round holds for both.
//! * Counts of the encoders are whole: two readings at the ends of a window are off
//!   by up to half a count each, whatever was driven. That is known and taken out.
//! * The true poses of a recording have noise, too. Where its deviation is given, it
//!   is taken out like the half counts.
//! * The half count at the end of a window is that at the beginning of the next, and so is
//!   the noise of the true pose there, so the errors of neighbours hang together; they are
//!   taken as independent.
//!   They are negligible compared with the slip of a window of more than some counts.
//! * A fit that did not converge, or whose α are those of no robot, is refused: the true
//!   poses of a recording can be wrong.
//! * A number that a log does not tell is not made up. A robot that never turns on
//!   the spot says next to nothing of α₁ and α₄.

mod recorder;
mod scoring;
mod windows;

use serde::Serialize;

pub use recorder::{FitMotion, Options};
pub use scoring::fit;
pub use windows::{Left, Window, Windows};

/// A larger α is that of no robot: half a metre, or half a radian, off after one.
const MOST: f64 = 0.25;

/// How much a log says of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Identifiability {
    /// The number is more than twice its standard error.
    Well,
    /// It is not: it may as well be 0.
    Hardly,
    /// Nothing depends on it, or on it apart from another.
    Not,
}

/// One of the four.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Alpha {
    /// The number, at least 0.
    pub value: f64,
    /// Its standard error; `None` where nothing depends on it.
    pub std_error: Option<f64>,
    /// How much the log says of it.
    pub told: Identifiability,
}

/// A part of the errors that comes again and again, which a variance does not
/// describe: a wheel that is larger than is said, a track that is wider.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Systematic {
    /// Error per unit.
    pub value: f64,
    /// Its standard error.
    pub std_error: f64,
}

impl Systematic {
    /// Whether it is more than chance.
    pub fn is_there(&self) -> bool {
        self.value.abs() > 3.0 * self.std_error
    }
}

/// The result of a fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MotionFit {
    /// α₁ to α₄.
    pub alphas: [Alpha; 4],
    /// Windows that were fitted to.
    pub windows: usize,
    /// Ticks of a window, on average.
    pub ticks_a_window: f64,
    /// Windows that were left out.
    pub left: Left,
    /// Log likelihood of each round.
    pub rounds: Vec<f64>,
    /// Whether it stopped because nothing changed any more.
    pub converged: bool,
    /// Error ahead per metre driven; `None` if it drove none.
    pub ahead_per_m: Option<Systematic>,
    /// Error of heading per metre driven, rad/m.
    pub turn_per_m: Option<Systematic>,
    /// Error of heading per radian turned; `None` if it never turned.
    pub turn_per_rad: Option<Systematic>,
}

impl MotionFit {
    /// Why these are no α of a robot, if they are not.
    pub fn problem(&self) -> Option<String> {
        if !self.converged {
            let rounds = self.rounds.len() - 1;
            return Some(format!(
                "the fit did not converge in {rounds} rounds: give a longer log, with straights, \
                 curves and turns on the spot"
            ));
        }
        let well = |a: &&Alpha| a.told == Identifiability::Well && a.value > MOST;
        let worst = self.alphas.iter().filter(well).map(|a| a.value).fold(0.0, f64::max);
        (worst > 0.0).then(|| {
            format!(
                "an α of {worst:.3} would put the wheels off by {:.1} m or rad after a metre or a \
                 radian: the true poses of this log contradict its odometry; `score --log LOG` draws \
                 both",
                worst.sqrt()
            )
        })
    }

    /// The numbers that the log tells, as flags of a filter; none of a fit that is refused.
    pub fn flags(&self) -> String {
        if self.problem().is_some() {
            return String::new();
        }
        let told = self.alphas.iter().enumerate().filter(|(_, a)| a.told == Identifiability::Well);
        let flags = told.map(|(i, a)| format!("--alpha{} {:.3e}", i + 1, a.value));
        flags.collect::<Vec<_>>().join(" ")
    }
}

#[cfg(test)]
mod tests;
