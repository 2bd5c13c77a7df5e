//! Where a driver believes to be: what it asks of the filter it carries.

use nalgebra::Matrix3;
use rusty_contract::reply::Innovation;
use rusty_contract::{Estimate, Start};
use rusty_geometry::{EncoderTicks, SE2};

use crate::ekf::Ekf;
use crate::scan_match::ScanMatch;
use crate::tangent::{estimate, symmetric};
use crate::{Motion, Odometry, OdometryNoise};

/// A filter inside another program: it is told what a tick showed, and asked
/// where the robot is.
pub trait Localiser {
    /// Takes the encoder counts at the end of a tick.
    fn advance(&mut self, ticks: EncoderTicks);

    /// Takes the scan at the end of the same tick, if there is one: how
    /// surprising it was, where the filter says so.
    fn scan(&mut self, ranges_m: &[f64]) -> Option<Innovation>;

    /// The believed pose of the body in the world frame.
    fn pose_in_world(&self) -> SE2;

    /// Covariance (m, m, rad) of the error τ: truth = believed ⊞ τ.
    fn covariance(&self) -> Matrix3<f64>;

    /// The answer that says all of it.
    fn estimate(&self, innovation: Option<Innovation>) -> Estimate {
        Estimate { innovation, ..estimate(&self.pose_in_world(), &self.covariance()) }
    }
}

/// Dead reckoning with a covariance: the filter of a driver that needs no place.
#[derive(Clone, Debug)]
pub struct Reckoning {
    odometry: Odometry,
    pose_in_world: SE2,
    covariance: Matrix3<f64>,
}

impl Reckoning {
    /// Begins where it is told, or else at the origin, which then is where the
    /// robot stands, and is sure of it.
    #[must_use]
    pub fn new(start: &Start, noise: OdometryNoise) -> Self {
        Self {
            odometry: Odometry::new(start.robot.drive, noise),
            pose_in_world: start.initial_pose.unwrap_or_default(),
            // What rounding leaves to doubt: a covariance of 0 has no inverse.
            covariance: Matrix3::identity() * 1e-8,
        }
    }
}

impl Localiser for Reckoning {
    fn advance(&mut self, ticks: EncoderTicks) {
        self.odometry.advance(ticks);
        let motion: Motion = self.odometry.take();
        self.covariance = symmetric(&motion.propagate(&self.covariance));
        self.pose_in_world = self.pose_in_world.compose(&motion.now_in_then);
    }

    fn scan(&mut self, _: &[f64]) -> Option<Innovation> {
        None
    }

    fn pose_in_world(&self) -> SE2 {
        self.pose_in_world
    }

    fn covariance(&self) -> Matrix3<f64> {
        self.covariance
    }
}

impl Localiser for Ekf {
    fn advance(&mut self, ticks: EncoderTicks) {
        Self::advance(self, ticks);
    }

    fn scan(&mut self, ranges_m: &[f64]) -> Option<Innovation> {
        Self::scan(self, ranges_m)
    }

    fn pose_in_world(&self) -> SE2 {
        Self::pose_in_world(self)
    }

    fn covariance(&self) -> Matrix3<f64> {
        Self::covariance(self)
    }
}

impl Localiser for ScanMatch {
    fn advance(&mut self, ticks: EncoderTicks) {
        Self::advance(self, ticks);
    }

    fn scan(&mut self, ranges_m: &[f64]) -> Option<Innovation> {
        Self::scan(self, ranges_m).innovation
    }

    fn pose_in_world(&self) -> SE2 {
        self.pose().0
    }

    fn covariance(&self) -> Matrix3<f64> {
        self.pose().1
    }
}

#[cfg(test)]
#[path = "told_tests.rs"]
pub(crate) mod told_tests;
