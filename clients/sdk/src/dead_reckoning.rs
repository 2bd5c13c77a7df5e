//! Dead reckoning: wheels to pose, and nothing else.
//!
//! x̂ₜ = x̂ₜ₋₁ ⊞ (Δs, 0, Δθ) with Δs and Δθ from the encoder counts (Lynch and
//! Park, *Modern Robotics*, §13.4; the ⊞ of Solà et al., arXiv:1812.01537).
//! The arithmetic is the world's own, so every bit of drift comes from the gap
//! between wheel and floor. Reports no covariance: it has no belief about it.

use rusty_contract::{Reply, Start};
use rusty_geometry::{DiffDrive, EncoderCounts, SE2, odometry_delta};

use crate::{Filter, Tick};

/// The oldest navigation algorithm there is.
pub struct DeadReckoning {
    drive: DiffDrive,
    pose_in_world: SE2,
    last: EncoderCounts,
}

impl DeadReckoning {
    /// Starts at `pose_in_world` with counts of zero.
    #[must_use]
    pub fn new(drive: DiffDrive, pose_in_world: SE2) -> Self {
        Self { drive, pose_in_world, last: EncoderCounts::default() }
    }

    /// Starts at the initial pose of a run, or at the origin.
    #[must_use]
    pub fn of_start(start: &Start) -> Self {
        Self::new(start.robot.drive, start.initial_pose.unwrap_or_default())
    }

    /// Advances by one reading of the encoders and says where that leads.
    pub fn advance(&mut self, ticks: EncoderCounts) -> SE2 {
        let delta = odometry_delta(self.last, ticks, &self.drive);
        self.pose_in_world = self.pose_in_world.boxplus(&delta);
        self.last = ticks;
        self.pose_in_world
    }
}

impl Filter for DeadReckoning {
    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        self.advance(tick.encoders()).into()
    }
}
