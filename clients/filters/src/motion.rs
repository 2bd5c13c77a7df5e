//! What a filter believes of the wheels: the odometry motion model.
//!
//! Source: *Probabilistic Robotics*, §5.4, Table 5.6. A motion is a turn, a
//! straight piece and another turn, each disturbed by a normal error with
//! variances α₁ rot² + α₂ trans² for a turn and α₃ trans² + α₄ (rot₁² + rot₂²)
//! for the straight piece.
//!
//! Departures, and why:
//! * A motion is one reading of the encoders to the next, always. The variances
//!   above grow with the square of a motion's length, so the α of one interval
//!   are not those of another; fixed to a tick they are, and errors of many
//!   ticks add up on the group as independent errors do ([`Motion::push`]).
//! * A tick is an arc (the encoders say so), whose two turns are equal halves.
//!   The book takes them from the chord by `atan2`, which sees half a turn where
//!   a robot backs up. Its δ_trans is the length of the arc, which the wheels
//!   turn, and not that of the chord: over one tick the two are as good as
//!   equal.
//! * What is sampled is the error of the whole motion since the last scan, from
//!   a normal law in the tangent space at its end (Solà et al.,
//!   arXiv:1812.01537, §II-H): in the plane that is the banana the book draws.

use clap::Args;
use nalgebra::{Matrix3, Vector3};
use rusty_geometry::{DiffDrive, EncoderCounts, SE2, odometry_delta, trig};

use crate::numbers::number;

/// α₁ to α₄ of the odometry motion model, for motions of one tick. The defaults are
/// for wheels 0.16 m apart that slip by 2 % of each tick's way, independently:
/// α₁ = σ², α₂ = σ²/ℓ², α₃ = σ²/2, α₄ = σ²ℓ²/4.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
#[command(next_help_heading = "Motion model (Probabilistic Robotics, Table 5.6)")]
pub struct OdometryNoise {
    /// Variance of a turn per turn², both of one tick
    #[arg(long, value_name = "A1", default_value_t = 4e-4, value_parser = alpha)]
    pub alpha1: f64,

    /// Variance of a turn per distance², rad²/m²
    #[arg(long, value_name = "A2", default_value_t = 0.0156, value_parser = alpha)]
    pub alpha2: f64,

    /// Variance of a distance per distance²
    #[arg(long, value_name = "A3", default_value_t = 2e-4, value_parser = alpha)]
    pub alpha3: f64,

    /// Variance of a distance per turn², m²/rad²
    #[arg(long, value_name = "A4", default_value_t = 2.6e-6, value_parser = alpha)]
    pub alpha4: f64,
}

crate::numbers::default_of_command_line!(OdometryNoise);

fn alpha(text: &str) -> Result<f64, String> {
    number(text, |v| (0.0..=MOST_ALPHA).contains(&v), "a number from 0 to 1000000")
}

/// The most an α may be: beyond it squares of variances have no numbers.
const MOST_ALPHA: f64 = 1e6;

impl OdometryNoise {
    /// Covariance (m, m, rad) of the error of one tick's motion `step` (the
    /// twist of an arc), in the tangent space at its end.
    pub fn of_step(&self, step: &Vector3<f64>) -> Matrix3<f64> {
        let (trans_m, rot_rad) = (step.x, 0.5 * step.z);
        let (trans2, rot2) = (trans_m * trans_m, rot_rad * rot_rad);
        let turn = self.alpha1 * rot2 + self.alpha2 * trans2;
        let straight = self.alpha3 * trans2 + self.alpha4 * 2.0 * rot2;
        // (turn, straight, turn) to (x, y, θ) at the end of the motion.
        let (s, c) = trig::sin_cos(rot_rad);
        let j = Matrix3::new(trans_m * s, c, 0.0, trans_m * c, -s, 0.0, 1.0, 0.0, 1.0);
        j * Matrix3::from_diagonal(&Vector3::new(turn, straight, turn)) * j.transpose()
    }
}

/// How far the robot believes to have come since some moment, and how sure it
/// is of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Pose of the body now in the frame of the body then.
    pub now_in_then: SE2,
    /// Covariance (m, m, rad) of the error τ in the tangent space at the end:
    /// truth = `now_in_then` ⊞ τ.
    pub covariance: Matrix3<f64>,
}

impl Default for Motion {
    fn default() -> Self {
        Self { now_in_then: SE2::identity(), covariance: Matrix3::zeros() }
    }
}

impl Motion {
    /// Goes on by the arc `step`, whose error has the covariance `of_step` and
    /// is independent of all before.
    pub fn push(&mut self, step: &Vector3<f64>, of_step: &Matrix3<f64>) {
        self.covariance = carried(&self.covariance, &SE2::exp(step)) + of_step;
        self.now_in_then = self.now_in_then.boxplus(step);
    }

    /// The covariance of a pose with covariance `before` (in its own tangent
    /// space) after this motion.
    pub fn propagate(&self, before: &Matrix3<f64>) -> Matrix3<f64> {
        carried(before, &self.now_in_then) + self.covariance
    }
}

/// A covariance in the tangent space at a pose, in that at `pose ∘ motion`.
pub fn carried(covariance: &Matrix3<f64>, motion: &SE2) -> Matrix3<f64> {
    let ad = motion.inverse().adjoint();
    ad * covariance * ad.transpose()
}

/// Encoder counts to motions.
#[derive(Clone, Debug)]
pub struct Odometry {
    drive: DiffDrive,
    noise: OdometryNoise,
    last: EncoderCounts,
    since: Motion,
}

impl Odometry {
    /// Begins with counts of zero.
    pub fn new(drive: DiffDrive, noise: OdometryNoise) -> Self {
        Self { drive, noise, last: EncoderCounts::default(), since: Motion::default() }
    }

    /// Takes the counts at the end of a tick, and says what motion they mean
    /// since the last [`take`](Self::take).
    pub fn advance(&mut self, ticks: EncoderCounts) -> &Motion {
        let step = odometry_delta(self.last, ticks, &self.drive);
        self.last = ticks;
        self.since.push(&step, &self.noise.of_step(&step));
        &self.since
    }

    /// The motion since the last [`take`](Self::take).
    pub fn so_far(&self) -> &Motion {
        &self.since
    }

    /// The motion since the last call, and begins the next.
    pub fn take(&mut self) -> Motion {
        std::mem::take(&mut self.since)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    #[test]
    fn one_step_has_the_spread_of_the_book_s_samples() {
        // Table 5.6, a hundred thousand times, compared with the covariance.
        let noise = OdometryNoise { alpha1: 0.02, alpha2: 0.01, alpha3: 0.005, alpha4: 0.002 };
        let step = Vector3::new(0.3, 0.0, 0.5);
        let end = SE2::exp(&step);
        let (rot, trans) = (0.25, 0.3 * trig::sinc(0.25));
        let turn = (noise.alpha1 * rot * rot + noise.alpha2 * trans * trans).sqrt();
        let straight = (noise.alpha3 * trans * trans + noise.alpha4 * 2.0 * rot * rot).sqrt();
        let mut random = Random::new(1, 1);
        let (mut sum, count) = (Matrix3::zeros(), 100_000);
        for _ in 0..count {
            let rot1 = rot - turn * random.normal();
            let trans = trans - straight * random.normal();
            let rot2 = rot - turn * random.normal();
            let (s, c) = trig::sin_cos(rot1);
            let tau = SE2::new(trans * c, trans * s, rot1 + rot2).boxminus(&end);
            sum += tau * tau.transpose();
        }
        let (found, said) = (sum / f64::from(count), noise.of_step(&step));
        for (found, said) in found.iter().zip(said.iter()) {
            assert!((found - said).abs() < 0.03 * said.abs() + 2e-5, "{found} for {said}");
        }
    }

    #[test]
    fn errors_of_many_steps_add_up_on_the_group() {
        let noise = OdometryNoise { alpha2: 0.3, ..OdometryNoise::default() };
        let step = Vector3::new(0.02, 0.0, 0.01);
        let (root, mut said) = (noise.of_step(&step), Motion::default());
        (0..100).for_each(|_| said.push(&step, &root));
        let root = root.cholesky().unwrap().l();
        let mut random = Random::new(2, 1);
        let (mut sum, count) = (Matrix3::zeros(), 4000);
        for _ in 0..count {
            let mut pose = SE2::identity();
            for _ in 0..100 {
                let z = Vector3::from_fn(|_, _| random.normal());
                pose = pose.boxplus(&step).boxplus(&(root * z));
            }
            let tau = pose.boxminus(&said.now_in_then);
            sum += tau * tau.transpose();
        }
        let found = sum / f64::from(count);
        for i in 0..3 {
            let ratio = found[(i, i)] / said.covariance[(i, i)];
            assert!((ratio - 1.0).abs() < 0.1, "{i}: {ratio}");
        }
    }

    #[test]
    fn a_motion_in_two_pieces_is_the_motion() {
        let noise = OdometryNoise::default();
        let steps = [Vector3::new(0.1, 0.0, 0.2), Vector3::new(-0.05, 0.0, 0.4)];
        let (mut whole, mut first, mut second) =
            (Motion::default(), Motion::default(), Motion::default());
        for step in steps {
            whole.push(&step, &noise.of_step(&step));
        }
        first.push(&steps[0], &noise.of_step(&steps[0]));
        second.push(&steps[1], &noise.of_step(&steps[1]));
        let difference = second.propagate(&first.covariance) - whole.covariance;
        assert!(difference.norm() < 1e-18, "{difference}");
    }

    #[test]
    fn alphas_are_bounded() {
        assert_eq!((alpha("0"), alpha("1e6")), (Ok(0.0), Ok(1e6)));
        for nonsense in ["-1", "nan", "inf", "1e300", "1.1e6", "x"] {
            assert!(alpha(nonsense).is_err(), "{nonsense}");
        }
    }

    #[test]
    fn counts_become_motions() {
        let drive = DiffDrive::rusty();
        let mut odometry = Odometry::new(drive, OdometryNoise::default());
        odometry.advance(EncoderCounts { left: 14_223, right: 17_384 });
        let motion = odometry.take();
        assert!((motion.now_in_then.theta() - 1.000_088_36).abs() < 1e-8, "{motion:?}");
        assert_eq!(odometry.take(), Motion::default());
    }
}
