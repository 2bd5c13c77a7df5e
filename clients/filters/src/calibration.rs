//! Wheels as they turn out to be: odometry that learns its own constant errors.
//!
//! A wheel that is 1 % too large turns a robot off its way by 60 mrad in every
//! metre, always to the same side. A motion model with independent errors cannot
//! say that; a filter that believes it is surprised by every scan. Here four numbers
//! are believed in, too, and learned from what the scans say of each motion:
//!
//! * the scale of ways, ds → (1 + a) ds,
//! * the scale of turns, dθ → (1 + b) dθ,
//! * the turn in each metre, dθ → dθ + c ds, rad/m,
//! * how far ahead of the middle of the wheels the frame lies that scans are given
//!   in, l, m: where a laser's place is not quite what it is said to be, a turn on
//!   the spot moves it sideways.
//!
//! Source: the constant errors of wheels are those of J. Borenstein and L. Feng,
//! *Measurement and correction of systematic odometry errors in mobile robots*,
//! IEEE Trans. Robotics and Automation 12 (1996). Their E_d, the right wheel's
//! diameter over the left one's, is c: (E_d − 1)/track; their E_b, the true track
//! over the nominal one, is b: 1/E_b − 1. Learning them in the filter's state is
//! A. Martinelli et al., *Simultaneous localization and odometry self calibration for
//! mobile robot*, Autonomous Robots 22 (2007).
//!
//! The noise of the wheels is learned as well (`noise.rs`). α₁ to α₄ are its lower limits.
//!
//! Departure: pose and numbers are one Gaussian for the length of a motion only.
//! Between motions their correlation is dropped, so that what is constant and not
//! yet learned adds up over motions as if it were drawn anew for each.

use nalgebra::{Matrix3, Matrix3x4, Matrix4, Vector3, Vector4};
use rusty_geometry::{DiffDrive, EncoderCounts, SE2, trig};

use self::noise::NoiseFactors;
use crate::icp::Evidence;
use crate::motion::{Motion, OdometryNoise, Steps, carried};
use crate::tangent::{right_jacobian, right_jacobian_inverse, seen_from, symmetric};

/// Deviations of a, b, c and l before anything was learned: a tape measure's, and
/// some play.
const UNKNOWN: [f64; 4] = [0.02, 0.03, 0.05, 0.05];

/// A motion that is a greater surprise (χ² of three numbers, one in twenty) teaches
/// less: the greater it is, the less constant is what caused it.
const USUAL_CHI2: f64 = 7.8;

/// The middle of the wheels on the way, and how its end moves with a, b and c.
#[derive(Clone, Copy, Debug, Default)]
struct Way {
    now_in_then: SE2,
    /// Covariance of the error that is drawn, of turns and of distances as noisy as given.
    noise: [Matrix3<f64>; 2],
    sensitivity: Matrix3x4<f64>,
}

impl Way {
    fn push(&mut self, step: &Vector3<f64>, errors: &Vector4<f64>, of_step: &[Matrix3<f64>; 2]) {
        let [a, b, c, _] = [errors.x, errors.y, errors.z, errors.w];
        let believed = Vector3::new((1.0 + a) * step.x, step.y, (1.0 + b) * step.z + c * step.x);
        let arc = SE2::exp(&believed);
        let back = arc.inverse().adjoint();
        self.now_in_then = self.now_in_then.boxplus(&believed);
        for (noise, of_step) in self.noise.iter_mut().zip(of_step) {
            *noise = carried(noise, &arc) + of_step;
        }
        let mut of_twist = Matrix3x4::zeros();
        of_twist[(0, 0)] = step.x;
        of_twist[(2, 1)] = step.z;
        of_twist[(2, 2)] = step.x;
        self.sensitivity = back * self.sensitivity + right_jacobian(&believed) * of_twist;
    }
}

/// Odometry that learns its constant errors and its noise.
#[derive(Clone, Debug)]
pub struct LearningWheels {
    steps: Steps,
    /// a, b, c, l as believed.
    errors: Vector4<f64>,
    /// How sure that is.
    covariance: Matrix4<f64>,
    noise: NoiseFactors,
    since_key: Way,
    since_scan: Way,
}

impl LearningWheels {
    /// Begins with counts of zero and nothing learned.
    pub fn new(drive: DiffDrive, noise: OdometryNoise) -> Self {
        let unknown = Vector4::from(UNKNOWN);
        Self {
            steps: Steps::new(drive, noise),
            errors: Vector4::zeros(),
            covariance: Matrix4::from_diagonal(&unknown.component_mul(&unknown)),
            noise: NoiseFactors::given(),
            since_key: Way::default(),
            since_scan: Way::default(),
        }
    }

    /// Begins likewise, with unknown noise of the distances.
    pub fn with_unknown_noise(drive: DiffDrive, noise: OdometryNoise) -> Self {
        Self { noise: NoiseFactors::unknown(&noise), ..Self::new(drive, noise) }
    }

    /// a, b, c (rad/m) and l (m) as believed, and their covariance.
    pub fn errors(&self) -> (&Vector4<f64>, &Matrix4<f64>) {
        (&self.errors, &self.covariance)
    }

    /// Takes the counts at the end of a tick.
    pub fn advance(&mut self, ticks: EncoderCounts) {
        let (step, of_step) = self.steps.advance_in_parts(ticks);
        self.since_key.push(&step, &self.errors, &of_step);
        self.since_scan.push(&step, &self.errors, &of_step);
    }

    /// The motion since the last scan.
    pub fn since_scan(&self) -> Motion {
        self.seen(&self.since_scan).0
    }

    /// The motion since the last key scan.
    pub fn since_key(&self) -> Motion {
        self.seen(&self.since_key).0
    }

    /// A scan was made.
    pub fn begin_scan(&mut self) {
        self.since_scan = Way::default();
    }

    /// A key scan was made.
    pub fn begin_key(&mut self) {
        self.begin_scan();
        self.since_key = Way::default();
    }

    /// Learns from what a scan says of the motion since the last key scan. Once
    /// for each key scan: what scans in between say has the same errors in it.
    pub fn learn(&mut self, evidence: &Evidence) {
        let (prior, sensitivity) = self.seen(&self.since_key);
        let (mean, covariance) = seen_from(&prior, &evidence.at);
        let gain = &evidence.gain;
        let s = symmetric(&(gain * covariance * gain + evidence.noise));
        let Some(inverse) = s.cholesky().map(|s| s.inverse()) else { return };
        let surprise = evidence.measured - gain * mean;
        let chi2 = (surprise.transpose() * inverse * surprise).x;
        let surprising = (chi2 / USUAL_CHI2).max(1.0);
        // The noise of turns and of distances in what is measured.
        let of_end = gain * right_jacobian_inverse(&mean);
        let j = of_end * self.ahead().inverse().adjoint();
        let parts = self.since_key.noise.map(|noise| j * noise * j.transpose());
        self.noise.learn(&parts, &inverse, &surprise, surprising);
        let (s, inverse) = (s * surprising, inverse / surprising);
        // How the four numbers show in what is measured.
        let shown = of_end * sensitivity;
        let k = self.covariance * shown.transpose() * inverse;
        let learned = self.errors + k * surprise;
        // Joseph's form: what is left stays a covariance whatever k is.
        let rest = Matrix4::identity() - k * shown;
        let other = s - shown * self.covariance * shown.transpose();
        let rest = rest * self.covariance * rest.transpose() + k * other * k.transpose();
        if learned.iter().chain(rest.iter()).all(|value| value.is_finite()) {
            self.errors = learned;
            self.covariance = (rest + rest.transpose()) * 0.5;
        }
    }

    /// The frame that scans are given in, in that of the middle of the wheels.
    fn ahead(&self) -> SE2 {
        SE2::new(self.errors.w, 0.0, 0.0)
    }

    /// A way as scans see it: with the frame where it lies, with all that is not
    /// known of the wheels, and how its end moves with the four numbers.
    fn seen(&self, way: &Way) -> (Motion, Matrix3x4<f64>) {
        let ahead = self.ahead();
        let now_in_then = ahead.inverse() * way.now_in_then * ahead;
        let across = ahead.inverse().adjoint();
        let mut sensitivity = across * way.sensitivity;
        let (s, c) = trig::sin_cos(now_in_then.theta());
        sensitivity.set_column(3, &Vector3::new(1.0 - c, s, 0.0));
        let constant = sensitivity * self.covariance * sensitivity.transpose();
        let drawn = self.noise.sum(&way.noise);
        let covariance = symmetric(&(carried(&drawn, &ahead) + constant));
        (Motion { now_in_then, covariance }, sensitivity)
    }
}

mod noise;

#[cfg(test)]
mod tests {
    use super::*;

    /// Turns and straight ways by wheels with these errors, each motion measured to
    /// a millimetre and a milliradian.
    fn learned(truth: [f64; 4]) -> LearningWheels {
        let drive = DiffDrive::rusty();
        let mut wheels = LearningWheels::new(drive, OdometryNoise::default());
        let ahead = SE2::new(truth[3], 0.0, 0.0);
        let (mut left, mut right) = (0.0, 0.0);
        for motion in 0..90 {
            let (v_m, turn_rad) = [(0.01, 0.0), (0.0, 0.02), (0.006, -0.012)][motion % 3];
            let mut moved = SE2::identity();
            for _ in 0..40 {
                left += v_m - 0.5 * turn_rad * drive.track_m;
                right += v_m + 0.5 * turn_rad * drive.track_m;
                let turn_rad = (1.0 + truth[1]) * turn_rad + truth[2] * v_m;
                moved = moved.boxplus(&Vector3::new((1.0 + truth[0]) * v_m, 0.0, turn_rad));
                let counts =
                    drive.ticks_per_rev as f64 / (std::f64::consts::TAU * drive.wheel_radius_m);
                let count = |way_m: f64| (way_m * counts).round() as i64;
                wheels.advance(EncoderCounts { left: count(left), right: count(right) });
            }
            wheels.learn(&Evidence {
                at: ahead.inverse() * moved * ahead,
                gain: Matrix3::identity() * 1e6,
                measured: Vector3::zeros(),
                noise: Matrix3::identity() * 1e6,
            });
            wheels.begin_key();
        }
        wheels
    }

    #[test]
    fn constant_errors_are_learned() {
        for truth in [[0.0; 4], [0.02, -0.01, 0.06, 0.09], [-0.03, 0.04, -0.03, -0.05]] {
            let wheels = learned(truth);
            let (errors, covariance) = wheels.errors();
            for k in 0..4 {
                let deviation = covariance[(k, k)].sqrt();
                let off = errors[k] - truth[k];
                assert!(off.abs() < 3.0 * deviation + 2e-4, "{k}: {off} of {truth:?}, {deviation}");
                assert!(deviation < 0.2 * UNKNOWN[k], "{k}: {deviation}");
            }
        }
    }

    #[test]
    fn the_noise_of_distances_is_learned() {
        for std_m in [0.02, 0.06] {
            let mut wheels = LearningWheels::new(DiffDrive::rusty(), OdometryNoise::default());
            let mut random = crate::Random::new(3, 1);
            for k in 1..=400 {
                wheels.advance(EncoderCounts { left: 9000 * k, right: 9000 * k });
                let counted = wheels.since_key().now_in_then;
                let off = Vector3::new(std_m * random.normal(), 0.0, 0.0);
                wheels.learn(&Evidence {
                    at: counted.boxplus(&off),
                    gain: Matrix3::identity() * 1e6,
                    measured: Vector3::zeros(),
                    noise: Matrix3::identity() * 1e6,
                });
                wheels.begin_key();
            }
            wheels.advance(EncoderCounts { left: 9000 * 401, right: 9000 * 401 });
            let said = wheels.since_key().covariance[(0, 0)].sqrt();
            assert!((said / std_m - 1.0).abs() < 0.15, "{said} for {std_m}");
        }
    }

    #[test]
    fn a_surprise_teaches_as_a_measurement_of_more_noise_does() {
        let mut wheels = LearningWheels::new(DiffDrive::rusty(), OdometryNoise::default());
        for k in 1..=30 {
            wheels.advance(EncoderCounts { left: 150 * k, right: 190 * k });
        }
        let (prior, _) = wheels.seen(&wheels.since_key);
        let gain = Matrix3::identity() * 1e5;
        let mut evidence = Evidence {
            at: prior.now_in_then,
            gain,
            measured: gain * Vector3::new(0.1, -0.05, 0.1),
            noise: gain,
        };
        let s = symmetric(&(gain * prior.covariance * gain + evidence.noise));
        let inverse = s.try_inverse().unwrap();
        let chi2 = (evidence.measured.transpose() * inverse * evidence.measured).x;
        assert!(chi2 > 3.0 * USUAL_CHI2, "{chi2}");
        let mut surprised = wheels.clone();
        surprised.learn(&evidence);
        evidence.noise += s * (chi2 / USUAL_CHI2 - 1.0);
        wheels.learn(&evidence);
        let off = surprised.errors - wheels.errors;
        let unlike = surprised.covariance - wheels.covariance;
        assert!(off.norm() < 1e-9 && unlike.norm() < 1e-12, "{off} {unlike}");
        assert!(wheels.covariance.trace() < UNKNOWN.iter().map(|u| u * u).sum());
    }

    #[test]
    fn the_end_of_a_way_moves_with_the_errors_as_it_says() {
        let drive = DiffDrive::rusty();
        let driven = |errors: Vector4<f64>| {
            let mut wheels = LearningWheels::new(drive, OdometryNoise::default());
            wheels.errors = errors;
            for k in 1..=30 {
                wheels.advance(EncoderCounts { left: 150 * k, right: 190 * k });
            }
            wheels.seen(&wheels.since_key)
        };
        let at = Vector4::new(0.01, -0.02, 0.03, 0.07);
        let (motion, sensitivity) = driven(at);
        for k in 0..4 {
            let mut by = Vector4::zeros();
            by[k] = 1e-6;
            let [more, less] = [at + by, at - by].map(|errors| driven(errors).0.now_in_then);
            let found =
                (more.boxminus(&motion.now_in_then) - less.boxminus(&motion.now_in_then)) / 2e-6;
            assert!((found - sensitivity.column(k)).norm() < 1e-6, "{k}: {found} {sensitivity}");
        }
    }
}
