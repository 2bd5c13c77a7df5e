//! What a filter believes of the wheels: the odometry motion model.
//!
//! Source: *Probabilistic Robotics*, §5.4, Table 5.6. A motion is a turn, a
//! straight piece and another turn, each disturbed by a normal error.
//!
//! Departures, and why:
//! * Variances are proportional to the path and not to its square: α₁ |Δθ| + α₂ |Δs|
//!   for the heading, half of it in each turn, and α₃ |Δs| + α₄ |Δθ| for the straight
//!   piece. Those of Table 5.6 depend on the number of pieces that a path is cut into:
//!   n pieces have 1/n of the variance of one. Here a path has the same variance at
//!   every rate, as for wheels with independent errors in each piece of their way
//!   (K. S. Chong, L. Kleeman, *Accurate odometry and error modelling for a mobile
//!   robot*, ICRA 1997).
//! * A motion is one reading of the encoders to the next, always; the errors of many
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

/// α₁ to α₄ of the odometry motion model. The defaults are for wheels ℓ = 0.16 m apart
/// whose ways have independent errors of variance k = 2e-5 m² per metre, a slip of 2 % in
/// every 5 cm: α₁ = k/ℓ, α₂ = 2k/ℓ², α₃ = k/2, α₄ = kℓ/4. The simulator draws its slip per
/// tick: they fit it at 10 Hz and 0.5 m/s, and are larger than needed at 50 Hz. The page
/// `docs/filters.md` has the reasons.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
#[command(next_help_heading = "Motion model (Probabilistic Robotics, section 5.4)")]
pub struct OdometryNoise {
    /// Variance of the heading per turn, rad²/rad
    #[arg(long, value_name = "A1", default_value_t = 1.25e-4, value_parser = alpha)]
    pub alpha1: f64,

    /// Variance of the heading per distance, rad²/m
    #[arg(long, value_name = "A2", default_value_t = 1.5625e-3, value_parser = alpha)]
    pub alpha2: f64,

    /// Variance of the distance per distance, m²/m
    #[arg(long, value_name = "A3", default_value_t = 1e-5, value_parser = alpha)]
    pub alpha3: f64,

    /// Variance of the distance per turn, m²/rad
    #[arg(long, value_name = "A4", default_value_t = 8e-7, value_parser = alpha)]
    pub alpha4: f64,
}

crate::numbers::default_of_command_line!(OdometryNoise);

fn alpha(text: &str) -> Result<f64, String> {
    number(text, |v| (0.0..=MOST_ALPHA).contains(&v), "a number from 0 to 1000000")
}

/// The most an α may be: beyond it squares of variances have no numbers.
const MOST_ALPHA: f64 = 1e6;

impl OdometryNoise {
    /// Variances of each of the two turns (rad²) and of the straight piece (m²) of a
    /// motion along `way`, (m, 0, rad).
    pub(crate) fn variances(&self, way: &Vector3<f64>) -> (f64, f64) {
        let (trans_m, rot_rad) = (way.x.abs(), way.z.abs());
        let turn = 0.5 * (self.alpha1 * rot_rad + self.alpha2 * trans_m);
        (turn, self.alpha3 * trans_m + self.alpha4 * rot_rad)
    }

    /// Covariance (m, m, rad) of the error of one tick's motion `step` (the
    /// twist of an arc), in the tangent space at its end.
    pub fn of_step(&self, step: &Vector3<f64>) -> Matrix3<f64> {
        self.covariance(step, step)
    }

    /// The same where only `way` of the motion has errors.
    fn covariance(&self, step: &Vector3<f64>, way: &Vector3<f64>) -> Matrix3<f64> {
        let (turn, straight) = self.variances(way);
        let (trans_m, rot_rad) = (step.x, 0.5 * step.z);
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

/// Encoder counts to the motions of ticks. A wheel at the edge of a count may count to
/// and fro: a single count that takes back the one before adds no error.
#[derive(Clone, Debug)]
pub(crate) struct Steps {
    drive: DiffDrive,
    noise: OdometryNoise,
    last: EncoderCounts,
    /// The last difference of each wheel that was not 0, at most 2 counts.
    moved: EncoderCounts,
}

impl Steps {
    /// Begins with counts of zero.
    pub(crate) fn new(drive: DiffDrive, noise: OdometryNoise) -> Self {
        let zero = EncoderCounts::default();
        Self { drive, noise, last: zero, moved: zero }
    }

    /// Takes the counts at the end of a tick. Returns the twist of its arc and the
    /// covariance of the error.
    pub(crate) fn advance(&mut self, counts: EncoderCounts) -> (Vector3<f64>, Matrix3<f64>) {
        let (step, way) = self.step(counts);
        (step, self.noise.covariance(&step, &way))
    }

    /// The same with that covariance in two parts: of the turns (α₁, α₂) and of the
    /// distances (α₃, α₄).
    pub(crate) fn advance_in_parts(
        &mut self,
        counts: EncoderCounts,
    ) -> (Vector3<f64>, [Matrix3<f64>; 2]) {
        let (step, way) = self.step(counts);
        let turns = OdometryNoise { alpha3: 0.0, alpha4: 0.0, ..self.noise };
        let distances = OdometryNoise { alpha1: 0.0, alpha2: 0.0, ..self.noise };
        (step, [turns, distances].map(|noise| noise.covariance(&step, &way)))
    }

    /// The twist of the arc of a tick, and the part of it that has errors.
    fn step(&mut self, counts: EncoderCounts) -> (Vector3<f64>, Vector3<f64>) {
        let step = odometry_delta(self.last, counts, &self.drive);
        let start = EncoderCounts {
            left: without_fro(&mut self.moved.left, self.last.left, counts.left),
            right: without_fro(&mut self.moved.right, self.last.right, counts.right),
        };
        self.last = counts;
        (step, odometry_delta(start, counts, &self.drive))
    }
}

/// Returns the count from which the way of a wheel to `count` begins: `last`, or `count`
/// if the wheel only took back a single count.
fn without_fro(moved: &mut i64, last: i64, count: i64) -> i64 {
    let difference = count.wrapping_sub(last);
    let is_taken_back = difference.unsigned_abs() == 1 && difference == -*moved;
    if difference != 0 {
        // Only single counts are ever compared.
        *moved = difference.clamp(-2, 2);
    }
    if is_taken_back { count } else { last }
}

/// Encoder counts to motions.
#[derive(Clone, Debug)]
pub struct Odometry {
    steps: Steps,
    since: Motion,
}

impl Odometry {
    /// Begins with counts of zero.
    pub fn new(drive: DiffDrive, noise: OdometryNoise) -> Self {
        Self { steps: Steps::new(drive, noise), since: Motion::default() }
    }

    /// Takes the counts at the end of a tick, and says what motion they mean
    /// since the last [`take`](Self::take).
    pub fn advance(&mut self, ticks: EncoderCounts) -> &Motion {
        let (step, of_step) = self.steps.advance(ticks);
        self.since.push(&step, &of_step);
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
        // Half of 0.02 · 0.5 + 0.01 · 0.3 in each turn; 0.005 · 0.3 + 0.002 · 0.5.
        let (turn, straight) = (0.0065_f64.sqrt(), 0.0025_f64.sqrt());
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

    /// The covariance of an arc that is cut into `pieces`.
    fn in_pieces(noise: OdometryNoise, arc: Vector3<f64>, pieces: u32) -> Matrix3<f64> {
        let (step, mut whole) = (arc / f64::from(pieces), Motion::default());
        (0..pieces).for_each(|_| whole.push(&step, &noise.of_step(&step)));
        whole.covariance
    }

    #[test]
    fn a_straight_path_has_the_variances_of_its_integral() {
        let noise = OdometryNoise { alpha2: 0.02, alpha3: 0.003, ..OdometryNoise::default() };
        for pieces in [1, 10, 100] {
            let found = in_pieces(noise, Vector3::new(2.0, 0.0, 0.0), pieces);
            // A heading error at s moves the end sideways: ∫ α₂ (L − s)² ds, by the
            // trapezoidal rule.
            let (l, d) = (2.0_f64, 2.0 / f64::from(pieces));
            let across = 0.02 * (l * l * l / 3.0 + l * d * d / 6.0);
            let expected = [0.003 * l, across, 0.02 * l, 0.02 * l * l / 2.0];
            let found = [found[(0, 0)], found[(1, 1)], found[(2, 2)], found[(1, 2)]];
            for (found, expected) in found.iter().zip(expected) {
                assert!((found / expected - 1.0).abs() < 1e-9, "{found} for {expected}");
            }
        }
    }

    #[test]
    fn a_path_has_the_same_variance_at_every_rate() {
        // A curve, a turn on the spot, backwards: 10 ticks or 50 for the same way.
        let noise = OdometryNoise::default();
        for arc in [[1.0, 1.0], [0.0, 3.0], [-0.5, 0.4]] {
            let arc = Vector3::new(arc[0], 0.0, arc[1]);
            let [slow, fast] = [10, 50].map(|n| in_pieces(noise, arc, n));
            assert!((slow - fast).norm() < 0.02 * fast.norm(), "{slow} {fast}");
            let heading = noise.alpha1 * arc.z.abs() + noise.alpha2 * arc.x.abs();
            for found in [slow, fast] {
                assert!((found[(2, 2)] / heading - 1.0).abs() < 1e-9, "{found}");
            }
        }
    }

    #[test]
    fn errors_of_many_steps_add_up_on_the_group() {
        let noise = OdometryNoise { alpha2: 0.012, ..OdometryNoise::default() };
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

    #[test]
    fn a_count_to_and_fro_is_no_way_and_all_others_are() {
        let way_m = |counts: &[i64]| {
            let noise = OdometryNoise { alpha1: 0.0, alpha2: 0.0, alpha3: 1.0, alpha4: 0.0 };
            let mut odometry = Odometry::new(DiffDrive::rusty(), noise);
            for count in counts {
                odometry.advance(EncoderCounts { left: *count, right: *count });
            }
            odometry.so_far().covariance[(0, 0)]
        };
        let count_m = rusty_geometry::tick_length(&DiffDrive::rusty());
        for (counts, ways) in [
            (&[1, 0, 0, 1, 0, 1][..], 1),
            (&[1, 2, 3, 4], 4),
            (&[1, 2, 1, 0, -1], 4),
            (&[5, 4, 5], 6),
            (&[100, 200, 100], 300),
        ] {
            let found = way_m(counts) / count_m;
            assert!((found - f64::from(ways)).abs() < 1e-9, "{found} of {counts:?}");
        }
    }
}
