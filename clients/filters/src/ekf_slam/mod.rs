//! EKF SLAM: the pose and a map of landmarks in one Gaussian.
//!
//! Source: *Probabilistic Robotics*, chapter 10: Table 10.1 (known correspondences),
//! Table 10.2 (unknown correspondences: maximum likelihood, and a threshold for new
//! landmarks), §10.3.3 (the provisional landmark list). [`crate::landmarks`] has the
//! measurement model, [`joint`] the covariance.
//!
//! Departures, and why:
//! * The frame begins at the initial pose, or at the origin if that is not given. The
//!   first pose is exact in it.
//! * The error of the pose is a tangent vector, as in [`crate::ekf`]. After each
//!   correction the covariance is carried to the tangent space at the new pose.
//! * Landmarks are added to the state when they are first seen, with the covariance of the
//!   pose and the reading. Table 10.1 begins with all N landmarks of infinite variance,
//!   which has the same limit.
//! * Table 10.2 creates a landmark and then removes it if another one is likelier. Here
//!   the decision is made before: [`crate::landmarks::Association`].
//! * Landmarks are never removed from the map. It has at most
//!   [`MOST_LANDMARKS`], later ones are not used.
//!
//! A linearised filter becomes too sure of its heading, and later of everything (S. Huang,
//! G. Dissanayake, IEEE Trans. Robotics 23, 2007): `docs/filters.md` has the figures.

pub mod joint;
mod provisional;

use clap::Args;
use nalgebra::{Matrix3, Vector2};
use rusty_clients::{ClientError, Filter, Tick};
use rusty_contract::{Estimate, Innovation, LandmarkReading, Reply, Start};
use rusty_geometry::{EncoderCounts, SE2};

use self::joint::Joint;
use self::provisional::Provisional;
use crate::landmarks::{Candidate, LandmarkModel, LandmarkOptions, MOST_LANDMARKS, Match};
use crate::tangent::{estimate, right_jacobian};
use crate::{Odometry, OdometryNoise};

/// Variance of the first pose (m², rad²): a covariance of 0 has no inverse.
const FIRST: f64 = 1e-8;

/// Localise and map landmarks with an extended Kalman filter
///
/// The state of this EKF (Probabilistic Robotics, chapter 10) has the pose and all
/// landmarks that were seen, with their joint covariance. It uses encoders, ranges and
/// bearings of landmarks, and no map. Readings without identity are matched by maximum
/// likelihood. It answers every tick with a pose and a covariance, and reports the
/// innovation (NIS).
#[derive(Args, Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// What is believed of the wheels.
    #[command(flatten)]
    pub odometry: OdometryNoise,

    /// What is believed of the readings.
    #[command(flatten)]
    pub landmarks: LandmarkOptions,

    /// Readings of a new landmark without identity before it is used
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub sightings: u32,
}

crate::numbers::default_of_command_line!(Options);

/// A landmark of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landmark {
    /// Its identity, where readings have one.
    pub id: Option<u32>,
    /// Its place in the frame of the map, m.
    pub at: Vector2<f64>,
}

/// EKF SLAM with landmarks.
#[derive(Clone, Debug)]
pub struct EkfSlam {
    odometry: Odometry,
    model: LandmarkModel,
    pose: SE2,
    landmarks: Vec<Landmark>,
    covariance: Joint,
    provisional: Provisional,
    sightings: u32,
}

impl EkfSlam {
    /// Begins at the initial pose, or at the origin, with an empty map.
    ///
    /// # Errors
    /// [`ClientError::Unusable`]: the robot has no landmark sensor.
    pub fn new(start: &Start, options: &Options) -> Result<Self, ClientError> {
        Ok(Self {
            odometry: Odometry::new(start.robot.drive, options.odometry),
            model: LandmarkModel::of_start(start, &options.landmarks)?,
            pose: start.initial_pose.unwrap_or_default(),
            landmarks: Vec::new(),
            covariance: Joint::new(&(Matrix3::identity() * FIRST)),
            provisional: Provisional::default(),
            sightings: options.sightings,
        })
    }

    /// Predicts by the encoder counts at the end of a tick (Table 10.1, lines 2 to 5).
    pub fn advance(&mut self, counts: EncoderCounts) {
        self.odometry.advance(counts);
        let motion = self.odometry.take();
        self.pose = self.pose.compose(&motion.now_in_then);
        self.covariance.predict(&motion);
    }

    /// Corrects by the readings of a tick (Table 10.1, lines 7 to 20), and adds the new
    /// landmarks. Returns the innovation, or `None` if no reading was used.
    pub fn see(&mut self, readings: &[LandmarkReading]) -> Option<Innovation> {
        let matches = self.matches(readings);
        let mut sum = Innovation { nis: 0.0, degrees: 0 };
        for (reading, of_reading) in readings.iter().zip(&matches) {
            let Match::Landmark(k) = *of_reading else { continue };
            if let Some(nis) = self.correct(k, reading) {
                sum.nis += nis;
                sum.degrees += 2;
            }
        }
        // New landmarks are seen from the corrected pose.
        self.provisional.begin_look();
        for (reading, of_reading) in readings.iter().zip(&matches) {
            if *of_reading == Match::New {
                self.add(reading);
            }
        }
        (sum.degrees > 0).then_some(sum)
    }

    /// Returns the landmark of each reading (Table 10.2).
    fn matches(&self, readings: &[LandmarkReading]) -> Vec<Match> {
        let known = |id| self.landmarks.iter().position(|l| l.id == Some(id));
        let candidates = |reading: &LandmarkReading, found: &mut Vec<Candidate>| {
            found.extend(self.landmarks.iter().enumerate().filter_map(|(k, landmark)| {
                let expected = LandmarkModel::expected(&self.pose, &landmark.at)?;
                let h = (&expected.by_pose, &expected.by_landmark);
                let s = self.covariance.innovation_covariance(k, h, &self.model.r);
                Candidate::new(k, &expected.residual(reading), &s)
            }));
        };
        self.model.association.matches(readings, known, candidates)
    }

    /// Corrects pose and map by a reading of landmark `k`. Returns its νᵀ S⁻¹ ν.
    fn correct(&mut self, k: usize, reading: &LandmarkReading) -> Option<f64> {
        let expected = LandmarkModel::expected(&self.pose, &self.landmarks[k].at)?;
        let (h, nu) = ((&expected.by_pose, &expected.by_landmark), expected.residual(reading));
        let correction = self.covariance.correct(k, h, &self.model.r, &nu)?;
        self.pose = self.pose.boxplus(&correction.tau);
        self.covariance.carry(&right_jacobian(&correction.tau));
        for (landmark, change_m) in self.landmarks.iter_mut().zip(&correction.landmarks_m) {
            landmark.at += change_m;
        }
        Some(correction.nis)
    }

    /// Adds the landmark of a reading, once it was seen often enough.
    fn add(&mut self, reading: &LandmarkReading) {
        let association = &self.model.association;
        let placed = self.model.place(&self.pose, reading);
        let id = association.id(reading);
        let is_sure = id.is_some()
            || self.provisional.see(&placed, &self.covariance.pose(), association, self.sightings);
        if is_sure && self.landmarks.len() < MOST_LANDMARKS {
            self.landmarks.push(Landmark { id, at: placed.at });
            self.covariance.add(&placed);
        }
    }

    /// The believed pose, and the covariance (m, m, rad) of its error τ.
    pub fn pose(&self) -> (SE2, Matrix3<f64>) {
        (self.pose, self.covariance.pose())
    }

    /// The map, in the order in which landmarks were added.
    pub fn landmarks(&self) -> &[Landmark] {
        &self.landmarks
    }

    /// The joint covariance of pose and map.
    pub fn covariance(&self) -> &Joint {
        &self.covariance
    }
}

impl Filter for EkfSlam {
    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        self.advance(tick.encoders());
        let innovation = tick.readings().landmarks().and_then(|seen| self.see(seen));
        Estimate { innovation, ..estimate(&self.pose, &self.covariance.pose()) }.into()
    }
}

#[cfg(test)]
mod tests;
