//! Landmarks: the measurement model of range and bearing, and the choice of the landmark
//! that a reading is of.
//!
//! Source: *Probabilistic Robotics*, §6.6, Table 6.4 and eq. 6.40 (the model), §7.5.1 and
//! Table 7.3 (correspondence of maximum likelihood), §10.3 and Table 10.2 (the threshold
//! of new landmarks). [`crate::ekf_landmarks`], [`crate::eif_landmarks`], [`crate::ekf_slam`]
//! and [`crate::fastslam`] use it.
//!
//! Departures, and why:
//! * The error of a pose is a tangent vector τ in the body frame, truth = pose ⊞ τ, as in
//!   [`crate::ekf`]. So the Jacobian of the pose does not depend on the heading.
//! * A signature is an exact number, or it is not there. It has no variance.
//! * There are two gates. A reading inside the inner one can be of the landmark, and a
//!   reading outside the outer one of all landmarks is of a new one. A reading between
//!   them is refused: Table 10.2 has one threshold α, which creates double landmarks.
//! * A reading that is nearly as likely for a second landmark is refused, too. A wrong
//!   match is worse than none.
//! * A landmark has at most one reading in a tick. The likelier one keeps it.

pub use self::known::KnownLandmarks;
use clap::Args;
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2};
use rusty_clients::ClientError;
use rusty_contract::config::sensors::LandmarkSensorConfig;
use rusty_contract::{LandmarkReading, Start};
use rusty_geometry::{SE2, trig, wrap_angle};

use crate::line_map::LineInnovation;
use crate::numbers::{number, positive, probability};

/// A landmark nearer than this has no usable bearing, m.
const LEAST_RANGE_M: f64 = 0.02;
/// The largest range that a filter uses, m.
const MOST_RANGE_M: f64 = 1e5;
/// The smallest deviations of a reading that a filter believes, m and rad.
const LEAST_STD: f64 = 1e-4;
/// The largest number of landmarks in a map that a filter makes.
pub const MOST_LANDMARKS: usize = 1000;

/// Assumptions about the readings of landmarks.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
#[command(next_help_heading = "Landmarks (Probabilistic Robotics, sections 6.6 and 7.5)")]
pub struct LandmarkOptions {
    /// Standard deviation of a range, m [default: the data sheet's, or 0.05]
    #[arg(long, value_name = "METRES", value_parser = positive)]
    pub range_std_m: Option<f64>,

    /// Standard deviation of a bearing, degrees [default: the data sheet's, or 2]
    #[arg(long, value_name = "DEGREES", value_parser = positive)]
    pub bearing_std_deg: Option<f64>,

    /// Do not use identities, even if readings have them
    #[arg(long)]
    pub ignore_ids: bool,

    /// Probability that the gate accepts a correct match
    #[arg(long, value_name = "P", default_value_t = 0.99, value_parser = probability)]
    pub gate: f64,

    /// Minimum likelihood ratio of the best and second match
    #[arg(long, value_name = "RATIO", default_value_t = 10.0, value_parser = ratio)]
    pub match_ratio: f64,

    /// Gate of all landmarks outside which a landmark is new
    #[arg(long, value_name = "P", default_value_t = 0.99999, value_parser = probability)]
    pub new_gate: f64,
}

crate::numbers::default_of_command_line!(LandmarkOptions);

fn ratio(text: &str) -> Result<f64, String> {
    number(text, |v| (1.0..=1e9).contains(&v), "a ratio from 1 to 1000000000")
}

/// The measurement model: z = (range m, bearing rad) with independent normal errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LandmarkModel {
    /// Covariance R of a reading (m², rad²), diagonal.
    pub r: Matrix2<f64>,
    /// The choice of the landmark.
    pub association: Association,
}

/// A reading that is expected of a landmark, and its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// Range m, bearing rad in the body frame.
    pub z: Vector2<f64>,
    /// ∂z/∂τ of the pose, truth = pose ⊞ τ.
    pub by_pose: Matrix2x3<f64>,
    /// ∂z/∂m of the landmark in the frame of the map.
    pub by_landmark: Matrix2<f64>,
}

/// The place of a landmark that a reading shows: the inverse of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Place in the frame of the map, m.
    pub at: Vector2<f64>,
    /// ∂m/∂τ of the pose.
    pub by_pose: Matrix2x3<f64>,
    /// Covariance by the errors of the reading, m².
    pub covariance: Matrix2<f64>,
}

impl LandmarkModel {
    /// Returns the model of the sensor that the participant is told of.
    ///
    /// # Errors
    /// [`ClientError::Unusable`]: the robot has no landmark sensor.
    pub fn of_start(start: &Start, options: &LandmarkOptions) -> Result<Self, ClientError> {
        let Some(sheet) = &start.sensors.landmarks else {
            return Err(ClientError::Unusable(format!(
                "{:?} needs readings of landmarks, and the robot has no landmark sensor: add \
                 [sensors.landmarks] to the scenario, and landmarks to its world file",
                start.name
            )));
        };
        let told = sheet.believed(&LandmarkSensorConfig::default());
        let bearing_std_rad = options.bearing_std_deg.map(f64::to_radians);
        let range_std_m = options.range_std_m.unwrap_or(told.range_std_m);
        Ok(Self::new(range_std_m, bearing_std_rad.unwrap_or(told.bearing_std_rad), options))
    }

    /// Returns the model with these deviations, m and rad.
    pub fn new(range_std_m: f64, bearing_std_rad: f64, options: &LandmarkOptions) -> Self {
        let variance = |std: f64| std.max(LEAST_STD) * std.max(LEAST_STD);
        let r = Matrix2::new(variance(range_std_m), 0.0, 0.0, variance(bearing_std_rad));
        Self { r, association: Association::new(options) }
    }

    /// Returns the reading that is expected of a landmark (eq. 6.40), and its derivatives;
    /// `None` where the landmark is at the robot.
    pub fn expected(pose: &SE2, landmark: &Vector2<f64>) -> Option<Expected> {
        let (s, c) = trig::sin_cos(pose.theta());
        let way = landmark - pose.translation();
        let d = Vector2::new(c * way.x + s * way.y, c * way.y - s * way.x);
        let range_m = trig::hypot(d.x, d.y);
        if range_m.is_nan() || range_m < LEAST_RANGE_M {
            return None;
        }
        let (ux, uy) = (d.x / range_m, d.y / range_m);
        // ∂z/∂d, where d is the landmark in the body frame.
        let by_d = Matrix2::new(ux, uy, -uy / range_m, ux / range_m);
        // d moves with τ by −(τ_x, τ_y) − τ_θ (−d_y, d_x), and with m by Rᵀ.
        let d_by_pose = Matrix2x3::new(-1.0, 0.0, d.y, 0.0, -1.0, -d.x);
        Some(Expected {
            z: Vector2::new(range_m, trig::atan2(d.y, d.x)),
            by_pose: by_d * d_by_pose,
            by_landmark: by_d * Matrix2::new(c, s, -s, c),
        })
    }

    /// Returns the place of the landmark of a reading, and its derivatives (Table 10.1,
    /// line 10).
    pub fn place(&self, pose: &SE2, reading: &LandmarkReading) -> Placed {
        let (s, c) = trig::sin_cos(pose.theta());
        let (sin, cos) = trig::sin_cos(reading.bearing_rad);
        let turn = Matrix2::new(c, -s, s, c);
        let d = Vector2::new(reading.range_m * cos, reading.range_m * sin);
        let by_z = turn * Matrix2::new(cos, -d.y, sin, d.x);
        Placed {
            at: pose.translation() + turn * d,
            by_pose: turn * Matrix2x3::new(1.0, 0.0, -d.y, 0.0, 1.0, d.x),
            covariance: by_z * self.r * by_z.transpose(),
        }
    }
}

impl Expected {
    /// Returns the reading less the expected one; the bearing is wrapped to (−π, π].
    pub fn residual(&self, reading: &LandmarkReading) -> Vector2<f64> {
        let bearing_rad = wrap_angle(reading.bearing_rad - self.z.y);
        Vector2::new(reading.range_m - self.z.x, bearing_rad)
    }

    /// Returns the innovation as [`crate::ekf::updated`] takes it: of a pose with this
    /// covariance, where `r` has all errors but that of the pose.
    pub fn innovation(
        &self,
        reading: &LandmarkReading,
        pose_covariance: &Matrix3<f64>,
        r: &Matrix2<f64>,
    ) -> LineInnovation {
        let h = self.by_pose;
        let s = h * pose_covariance * h.transpose() + r;
        LineInnovation { nu: self.residual(reading), h, r: *r, s }
    }
}

/// A landmark that a reading may be of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Index in the map of the filter.
    pub landmark: usize,
    /// νᵀ S⁻¹ ν.
    pub nis: f64,
    /// det S.
    pub det: f64,
}

impl Candidate {
    /// Returns the landmark with this innovation; `None` where S has no inverse.
    pub fn new(landmark: usize, nu: &Vector2<f64>, s: &Matrix2<f64>) -> Option<Self> {
        let (nis, det) = (nu.dot(&(s.try_inverse()? * nu)), s.determinant());
        let is_usable = nis >= 0.0 && nis.is_finite() && det > 0.0 && det.is_finite();
        is_usable.then_some(Self { landmark, nis, det })
    }

    /// −2 ln of the likelihood of the reading (Table 7.3), less 2 ln 2π.
    pub fn cost(&self) -> f64 {
        self.nis + trig::ln(self.det)
    }
}

/// Result of the association of a reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Match {
    /// The index of its landmark.
    Landmark(usize),
    /// A landmark that is not in the map.
    New,
    /// Not used: ambiguous, doubtful, or not a number.
    Refused,
}

/// The choice of the landmark of each reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Association {
    /// The largest νᵀ S⁻¹ ν of a match.
    pub inside: f64,
    /// The smallest νᵀ S⁻¹ ν of all landmarks for a reading of a new one.
    pub outside: f64,
    /// The smallest difference of the costs of the best and the second match.
    margin: f64,
    ignores_ids: bool,
}

impl Association {
    /// The gates are quantiles of χ² with two degrees, −2 ln(1 − p).
    pub fn new(options: &LandmarkOptions) -> Self {
        let quantile = |p: f64| -2.0 * trig::ln(1.0 - p);
        let inside = quantile(options.gate);
        Self {
            inside,
            outside: quantile(options.new_gate).max(inside),
            margin: 2.0 * trig::ln(options.match_ratio),
            ignores_ids: options.ignore_ids,
        }
    }

    /// Returns the identity of a reading, if it is to be used.
    pub fn id(&self, reading: &LandmarkReading) -> Option<u32> {
        reading.id().filter(|_| !self.ignores_ids)
    }

    /// Returns the match of every reading of a tick. `known` returns the index of an
    /// identity. `candidates` adds the landmarks that a reading without one may be of.
    pub fn matches(
        &self,
        readings: &[LandmarkReading],
        known: impl Fn(u32) -> Option<usize>,
        mut candidates: impl FnMut(&LandmarkReading, &mut Vec<Candidate>),
    ) -> Vec<Match> {
        let mut of_reading = Vec::new();
        let mut choose = |reading: &LandmarkReading| {
            let is_usable = (LEAST_RANGE_M..=MOST_RANGE_M).contains(&reading.range_m);
            if !is_usable || !reading.bearing_rad.is_finite() {
                return (Match::Refused, 0.0);
            }
            if let Some(id) = self.id(reading) {
                return (known(id).map_or(Match::New, Match::Landmark), 0.0);
            }
            of_reading.clear();
            candidates(reading, &mut of_reading);
            self.choose(&of_reading)
        };
        let mut all: Vec<(Match, f64)> = readings.iter().map(&mut choose).collect();
        for k in 0..all.len() {
            let (Match::Landmark(_), cost) = all[k] else { continue };
            let rivals =
                all.iter().enumerate().filter(|(other, of)| *other != k && of.0 == all[k].0);
            // Of equal costs the first one wins.
            let is_beaten = rivals.clone().any(|(other, of)| (of.1, other) < (cost, k));
            if is_beaten {
                all[k].0 = Match::Refused;
            }
        }
        all.into_iter().map(|(chosen, _)| chosen).collect()
    }

    /// Returns the likeliest match of a reading (Table 7.3), and its cost.
    pub fn choose(&self, candidates: &[Candidate]) -> (Match, f64) {
        let inside = candidates.iter().filter(|c| c.nis <= self.inside);
        let Some(best) = inside.clone().min_by(|a, b| a.cost().total_cmp(&b.cost())) else {
            let is_new = candidates.iter().all(|c| c.nis > self.outside);
            return (if is_new { Match::New } else { Match::Refused }, 0.0);
        };
        let is_rival =
            |c: &&Candidate| c.landmark != best.landmark && c.cost() < best.cost() + self.margin;
        if inside.clone().any(|c| is_rival(&c)) {
            return (Match::Refused, 0.0);
        }
        (Match::Landmark(best.landmark), best.cost())
    }
}

mod known;
#[cfg(test)]
pub(crate) mod test_robot;
#[cfg(test)]
mod tests;
