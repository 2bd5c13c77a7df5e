//! Estimators, as values in this process.

use rusty_contract::{Frame, Reply, Start, WeightedPose};
use rusty_geometry::{DiffDrive, EncoderCounts, SE2, odometry_delta};

/// An estimator, as its program would answer.
pub trait Estimator: Send {
    /// Answers a tick.
    fn update(&mut self, frame: &Frame) -> Reply;

    /// Adds the poses that it holds possible now.
    fn belief(&self, poses: &mut Vec<WeightedPose>) {
        let _ = poses;
    }
}

/// Dead reckoning, as the client of this name computes it without options.
pub struct DeadReckoning {
    drive: DiffDrive,
    pose_in_world: SE2,
    last: EncoderCounts,
}

impl DeadReckoning {
    /// Begins at the initial pose of a run, or at the origin.
    #[must_use]
    pub fn new(start: &Start) -> Self {
        let pose_in_world = start.initial_pose.unwrap_or_default();
        Self { drive: start.robot.drive, pose_in_world, last: EncoderCounts::default() }
    }
}

impl Estimator for DeadReckoning {
    fn update(&mut self, frame: &Frame) -> Reply {
        let delta = odometry_delta(self.last, frame.encoders(), &self.drive);
        self.last = frame.encoders();
        self.pose_in_world = self.pose_in_world.boxplus(&delta);
        self.pose_in_world.into()
    }
}
