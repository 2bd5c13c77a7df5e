//! The extended information filter: localisation by landmarks with the inverse of the
//! covariance.
//!
//! Source: *Probabilistic Robotics*, §3.5, Table 3.6. The state is the information matrix
//! Ω = Σ⁻¹ and the information vector ξ = Ω μ. What is a product in the Kalman filter is a
//! sum here and the other way round: a reading adds HᵀR⁻¹H to Ω and HᵀR⁻¹ν to ξ, so all
//! readings of a tick are added up, in any order, and the mean is computed once. The
//! prediction needs the two inverses that the Kalman filter does not (lines 2 to 4).
//!
//! Departures, and why:
//! * The state is a pose of SE(2) with a tangent error τ, truth = pose ⊞ τ, as in
//!   [`crate::ekf_landmarks`]: ξ = Ω τ is zero at the pose, and is kept for the length of
//!   one correction only.
//! * With one reading in a tick its answers are those of `ekf-landmarks`. With several, all
//!   are linearised at the prediction, and those of `ekf-landmarks` one after the other.

use clap::Args;
use nalgebra::{Matrix3, Vector3};
use rusty_clients::{ClientError, Filter, Tick};
use rusty_contract::{Estimate, Innovation, LandmarkReading, Reply, Start};
use rusty_geometry::{EncoderCounts, SE2};

use crate::ekf_landmarks::initial_pose;
use crate::landmarks::{KnownLandmarks, LandmarkOptions, Match};
use crate::start_options::StartOptions;
use crate::tangent::{estimate, placed, right_jacobian_inverse, symmetric};
use crate::{Odometry, OdometryNoise};

/// Localise on a map of landmarks with an extended information filter
///
/// The EIF (Probabilistic Robotics, Table 3.6) is the EKF of ekf-landmarks with the inverse
/// of the covariance: readings add up, and the prediction has the matrix inverses. It needs
/// the map and the initial pose, and no laser.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// What is believed of the wheels.
    #[command(flatten)]
    pub odometry: OdometryNoise,

    /// What is believed of the readings.
    #[command(flatten)]
    pub landmarks: LandmarkOptions,

    /// What is believed of the start.
    #[command(flatten)]
    pub start: StartOptions,
}

crate::numbers::default_of_command_line!(Options);

/// Information filter by landmarks.
#[derive(Clone, Debug)]
pub struct EifLandmarks {
    odometry: Odometry,
    known: KnownLandmarks,
    pose_in_world: SE2,
    /// Ω, 1/m², 1/m and 1/rad², of the error τ.
    information: Matrix3<f64>,
}

impl EifLandmarks {
    /// Begins at the initial pose.
    ///
    /// # Errors
    /// [`ClientError::Unusable`]: there is no landmark sensor, no map with landmarks, or no
    /// initial pose.
    pub fn new(start: &Start, options: &Options) -> Result<Self, ClientError> {
        Ok(Self {
            odometry: Odometry::new(start.robot.drive, options.odometry),
            known: KnownLandmarks::of_start(start, &options.landmarks)?,
            pose_in_world: initial_pose(start)?,
            information: inverse(&options.start.covariance()).unwrap_or_else(Matrix3::identity),
        })
    }

    /// Predicts by the encoder counts at the end of a tick (Table 3.6, lines 2 to 5):
    /// Ω̄ = (G Ω⁻¹ Gᵀ + R)⁻¹.
    pub fn advance(&mut self, counts: EncoderCounts) {
        self.odometry.advance(counts);
        let motion = self.odometry.take();
        let (pose_in_world, covariance) = placed(&self.pose_in_world, &self.covariance(), &motion);
        self.pose_in_world = pose_in_world;
        self.information = inverse(&covariance).unwrap_or(self.information);
    }

    /// Corrects by the readings of a tick (Table 3.6, lines 6 to 8). Returns the innovation
    /// of all of them, or `None` if no reading was used.
    pub fn see(&mut self, readings: &[LandmarkReading]) -> Option<Innovation> {
        let matches = self.known.matches(&self.pose_in_world, &self.covariance(), readings);
        let r_inverse = self.known.r().try_inverse()?;
        let (mut omega, mut xi) = (self.information, Vector3::zeros());
        let mut sum = Innovation { nis: 0.0, degrees: 0 };
        for (reading, of_reading) in readings.iter().zip(matches) {
            let Match::Landmark(k) = of_reading else { continue };
            let Some(expected) = self.known.expected(&self.pose_in_world, k) else { continue };
            let (h, nu) = (expected.by_pose, expected.residual(reading));
            omega += h.transpose() * r_inverse * h;
            xi += h.transpose() * r_inverse * nu;
            sum.nis += nu.dot(&(r_inverse * nu));
            sum.degrees += 2;
        }
        let tau = inverse(&omega)? * xi;
        // νᵀ S⁻¹ ν of all readings together, by the matrix inversion lemma.
        sum.nis = (sum.nis - xi.dot(&tau)).max(0.0);
        // The same error, seen from the pose that τ leads to.
        let j = right_jacobian_inverse(&tau);
        let omega = symmetric(&(j.transpose() * omega * j));
        let is_whole = tau.iter().chain(omega.iter()).all(|v| v.is_finite());
        if sum.degrees == 0 || !is_whole {
            return None;
        }
        self.pose_in_world = self.pose_in_world.boxplus(&tau);
        self.information = omega;
        Some(sum)
    }

    fn covariance(&self) -> Matrix3<f64> {
        inverse(&self.information).unwrap_or_else(Matrix3::identity)
    }

    /// The believed pose, world frame, and the covariance (m, m, rad) of its error τ.
    pub fn pose(&self) -> (SE2, Matrix3<f64>) {
        (self.pose_in_world, self.covariance())
    }
}

/// The inverse of a symmetric, positive matrix.
fn inverse(matrix: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    matrix.cholesky().map(|factor| symmetric(&factor.inverse()))
}

impl Filter for EifLandmarks {
    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        self.advance(tick.encoders());
        let innovation = tick.readings().landmarks().and_then(|seen| self.see(seen));
        let (pose, covariance) = self.pose();
        Estimate { innovation, ..estimate(&pose, &covariance) }.into()
    }
}

#[cfg(test)]
#[path = "landmarks/eif_tests.rs"]
mod tests;
