//! Dead reckoning with a covariance: the filter of a driver without a map.

use nalgebra::Matrix3;
use rusty_clients::{Filter, Tick};
use rusty_contract::{Reply, Start};
use rusty_geometry::SE2;

use crate::tangent::{estimate, placed};
use crate::{Odometry, OdometryNoise};

/// Dead reckoning with a covariance. It abstains without an initial pose.
#[derive(Clone, Debug)]
pub struct Reckoning {
    odometry: Odometry,
    pose_in_world: Option<SE2>,
    covariance: Matrix3<f64>,
}

impl Reckoning {
    /// Begins at the initial pose.
    pub fn new(start: &Start, noise: OdometryNoise) -> Self {
        Self {
            odometry: Odometry::new(start.robot.drive, noise),
            pose_in_world: start.initial_pose,
            // The error of rounding: a covariance of 0 has no inverse.
            covariance: Matrix3::identity() * 1e-8,
        }
    }
}

impl Filter for Reckoning {
    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        self.odometry.advance(tick.encoders());
        let motion = self.odometry.take();
        let Some(pose) = &mut self.pose_in_world else { return Reply::Abstain };
        (*pose, self.covariance) = placed(pose, &self.covariance, &motion);
        estimate(pose, &self.covariance).into()
    }
}
