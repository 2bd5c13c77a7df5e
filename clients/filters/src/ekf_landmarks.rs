//! EKF localisation by landmarks: where on a map of points, by range and bearing.
//!
//! Source: *Probabilistic Robotics*, Table 7.2 (known correspondences), and Table 7.3
//! (correspondences of maximum likelihood) for readings without identity.
//! [`crate::landmarks`] has the measurement model and the choice of the landmark.
//!
//! Departures, and why:
//! * The state is a pose of SE(2) with a tangent error, and the covariance is updated in
//!   Joseph's form: see [`crate::ekf`], whose update this is.
//! * The motion model is that of [`crate::motion`], not that of velocities.
//! * Matches are found before the first update. Updates are one after the other, each
//!   linearised where the last one led.
//! * A reading that is ambiguous or of no landmark of the map is not used.

use clap::Args;
use nalgebra::Matrix3;
use rusty_clients::{ClientError, Filter, Tick};
use rusty_contract::{Estimate, Innovation, LandmarkReading, Reply, Start};
use rusty_geometry::{EncoderCounts, SE2};

use crate::ekf::updated;
use crate::landmarks::{KnownLandmarks, LandmarkOptions, Match};
use crate::start_options::StartOptions;
use crate::tangent::{estimate, placed};
use crate::{Odometry, OdometryNoise};

/// Localise on a map of landmarks with an extended Kalman filter
///
/// The EKF (Probabilistic Robotics, Tables 7.2 and 7.3) predicts from the encoders and
/// corrects by range and bearing of landmarks. Readings without identity are matched by
/// maximum likelihood. It needs the map and the initial pose, and no laser. It answers
/// every tick with a pose and a covariance, and reports the innovation (NIS).
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

/// EKF localisation by landmarks.
#[derive(Clone, Debug)]
pub struct EkfLandmarks {
    odometry: Odometry,
    known: KnownLandmarks,
    pose_in_world: SE2,
    covariance: Matrix3<f64>,
}

impl EkfLandmarks {
    /// Begins at the initial pose.
    ///
    /// # Errors
    /// [`ClientError::Unusable`]: there is no landmark sensor, no map with landmarks, or no
    /// initial pose.
    pub fn new(start: &Start, options: &Options) -> Result<Self, ClientError> {
        let known = KnownLandmarks::of_start(start, &options.landmarks)?;
        Ok(Self {
            odometry: Odometry::new(start.robot.drive, options.odometry),
            known,
            pose_in_world: initial_pose(start)?,
            covariance: options.start.covariance(),
        })
    }

    /// Predicts by the encoder counts at the end of a tick (Table 7.2, lines 2 to 7).
    pub fn advance(&mut self, counts: EncoderCounts) {
        self.odometry.advance(counts);
        let motion = self.odometry.take();
        (self.pose_in_world, self.covariance) =
            placed(&self.pose_in_world, &self.covariance, &motion);
    }

    /// Corrects by the readings of a tick (Table 7.2). Returns the
    /// innovation, or `None` if no reading was used.
    pub fn see(&mut self, readings: &[LandmarkReading]) -> Option<Innovation> {
        let matches = self.known.matches(&self.pose_in_world, &self.covariance, readings);
        let mut sum = Innovation { nis: 0.0, degrees: 0 };
        for (reading, of_reading) in readings.iter().zip(matches) {
            let Match::Landmark(k) = of_reading else { continue };
            let Some(expected) = self.known.expected(&self.pose_in_world, k) else { continue };
            let innovation = expected.innovation(reading, &self.covariance, self.known.r());
            let corrected = updated(&self.pose_in_world, &self.covariance, &innovation);
            let Some(corrected) = corrected else { continue };
            (self.pose_in_world, self.covariance) = corrected;
            sum.nis += innovation.nis();
            sum.degrees += 2;
        }
        (sum.degrees > 0).then_some(sum)
    }

    /// The believed pose, world frame, and the covariance (m, m, rad) of its error τ.
    pub fn pose(&self) -> (SE2, Matrix3<f64>) {
        (self.pose_in_world, self.covariance)
    }
}

/// The initial pose, world frame.
pub(crate) fn initial_pose(start: &Start) -> Result<SE2, ClientError> {
    start.initial_pose.ok_or_else(|| {
        ClientError::Unusable(format!(
            "{:?} gets no initial pose, and a Gaussian cannot find it: give it \
             initial_pose = \"given\" in the scenario",
            start.name
        ))
    })
}

impl Filter for EkfLandmarks {
    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        self.advance(tick.encoders());
        let innovation = tick.readings().landmarks().and_then(|seen| self.see(seen));
        Estimate { innovation, ..estimate(&self.pose_in_world, &self.covariance) }.into()
    }
}

#[cfg(test)]
#[path = "landmarks/ekf_tests.rs"]
mod tests;
