//! A particle: a possible pose, and the map that follows from its path.
//!
//! Source: *Probabilistic Robotics*, Tables 13.1 and 13.2 (FastSLAM 1.0) and 13.3
//! (FastSLAM 2.0). Given the path, the landmarks are independent. So each has an EKF of two
//! numbers, and a map of N landmarks has N small matrices instead of a large one.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use rusty_contract::LandmarkReading;
use rusty_geometry::{SE2, trig};

use super::Variant;
use crate::Motion;
use crate::ekf::updated;
use crate::landmarks::{Candidate, Expected, LandmarkModel, MOST_LANDMARKS, Match};
use crate::line_map::LineInnovation;
use crate::mcl::root;

/// A landmark of a particle's map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landmark {
    /// Its identity, where readings have one.
    pub id: Option<u32>,
    /// Mean of its place, frame of the map, m.
    pub at: Vector2<f64>,
    /// Covariance of its place, m².
    pub covariance: Matrix2<f64>,
}

/// A possible pose with its map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particle {
    /// Pose of the body in the frame of the map.
    pub pose: SE2,
    /// In the order in which they were added.
    pub landmarks: Vec<Landmark>,
}

impl Particle {
    /// Moves, takes the readings at the end of the motion, and returns the logarithm of
    /// the weight. `z` are three standard normal numbers.
    ///
    /// Variant 1 draws the pose from the motion (Table 13.1). Variant 2 draws it
    /// from the motion and the readings (Table 13.3).
    pub fn step(
        &mut self,
        motion: &Motion,
        readings: &[LandmarkReading],
        model: &LandmarkModel,
        variant: Variant,
        z: &Vector3<f64>,
    ) -> f64 {
        let mut covariance = motion.covariance;
        self.pose = self.pose.compose(&motion.now_in_then);
        if variant == Variant::One {
            self.pose = self.pose.boxplus(&(root(&covariance) * z));
            covariance = Matrix3::zeros();
        }
        let matches = self.matches(readings, model, &covariance);
        let mut log_weight = 0.0;
        for (reading, of_reading) in readings.iter().zip(&matches) {
            let Match::Landmark(k) = *of_reading else {
                log_weight += unmatched(model);
                continue;
            };
            let Some(innovation) = self.innovation(k, reading, model, &covariance) else {
                log_weight += unmatched(model);
                continue;
            };
            log_weight += log_likelihood(&innovation);
            if variant == Variant::Two
                && let Some(corrected) = updated(&self.pose, &covariance, &innovation)
            {
                (self.pose, covariance) = corrected;
            }
        }
        if variant == Variant::Two {
            self.pose = self.pose.boxplus(&(root(&covariance) * z));
        }
        for (reading, of_reading) in readings.iter().zip(&matches) {
            match *of_reading {
                Match::Landmark(k) => self.correct(k, reading, model),
                Match::New => self.add(reading, model),
                Match::Refused => {}
            }
        }
        log_weight
    }

    /// Returns the landmark of each reading (Table 13.2): a separate
    /// decision of each particle.
    fn matches(
        &self,
        readings: &[LandmarkReading],
        model: &LandmarkModel,
        covariance: &Matrix3<f64>,
    ) -> Vec<Match> {
        let known = |id| self.landmarks.iter().position(|l| l.id == Some(id));
        let candidates = |reading: &LandmarkReading, found: &mut Vec<Candidate>| {
            found.extend((0..self.landmarks.len()).filter_map(|k| {
                let of = self.innovation(k, reading, model, covariance)?;
                Candidate::new(k, &of.nu, &of.s)
            }));
        };
        model.association.matches(readings, known, candidates)
    }

    /// Returns the innovation of a reading of landmark `k` for a pose with this covariance,
    /// 0 for a pose that is drawn. Its `r` is Q of Table 13.1.
    fn innovation(
        &self,
        k: usize,
        reading: &LandmarkReading,
        model: &LandmarkModel,
        covariance: &Matrix3<f64>,
    ) -> Option<LineInnovation> {
        let landmark = &self.landmarks[k];
        let expected = LandmarkModel::expected(&self.pose, &landmark.at)?;
        let q = with_landmark(&expected, &landmark.covariance, &model.r);
        Some(expected.innovation(reading, covariance, &q))
    }

    /// Corrects landmark `k` from the pose that was drawn (Table 13.1), in
    /// Joseph's form.
    fn correct(&mut self, k: usize, reading: &LandmarkReading, model: &LandmarkModel) {
        let landmark = &mut self.landmarks[k];
        let expected = LandmarkModel::expected(&self.pose, &landmark.at);
        let Some(expected) = expected else { return };
        let (h, p) = (&expected.by_landmark, &landmark.covariance);
        let Some(inverse) = with_landmark(&expected, p, &model.r).try_inverse() else { return };
        let gain = p * h.transpose() * inverse;
        let rest = Matrix2::identity() - gain * h;
        let joseph = rest * p * rest.transpose() + gain * model.r * gain.transpose();
        landmark.at += gain * expected.residual(reading);
        landmark.covariance = (joseph + joseph.transpose()) * 0.5;
    }

    /// Adds the landmark of a reading (Table 13.1).
    fn add(&mut self, reading: &LandmarkReading, model: &LandmarkModel) {
        if self.landmarks.len() < MOST_LANDMARKS {
            let placed = model.place(&self.pose, reading);
            let id = model.association.id(reading);
            self.landmarks.push(Landmark { id, at: placed.at, covariance: placed.covariance });
        }
    }
}

/// H Σ Hᵀ + R of a landmark.
fn with_landmark(expected: &Expected, covariance: &Matrix2<f64>, r: &Matrix2<f64>) -> Matrix2<f64> {
    let h = &expected.by_landmark;
    h * covariance * h.transpose() + r
}

/// Logarithm of the normal density of an innovation, times 2π: the factor is the same in
/// all particles.
fn log_likelihood(innovation: &LineInnovation) -> f64 {
    let log = -0.5 * (innovation.nis() + trig::ln(innovation.s.determinant()));
    if log.is_finite() { log } else { f64::MIN }
}

/// The same for a reading without a landmark, p₀ of Table 13.2: that of a reading at the
/// outer gate.
fn unmatched(model: &LandmarkModel) -> f64 {
    -0.5 * (model.association.outside + trig::ln(model.r.determinant()))
}
