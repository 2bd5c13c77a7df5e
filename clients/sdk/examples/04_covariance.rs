//! Dead reckoning that says how sure it is, so that a scorer can tell whether it
//! is right about that (NEES, docs/metrics.md).
//!
//! The error τ is that of `Estimate::covariance`: truth = estimate ⊞ τ. When both
//! move by u, and the truth by a little more, w, then to first order
//! τ' = Ad(exp(u)⁻¹) τ + w (J. Solà et al., arXiv:1812.01537, eqs. 31 and 63).
//! No filter is told what w is: it believes in wheels that slip.
use rusty_clients::nalgebra::{Matrix3, Vector3};
use rusty_clients::prelude::*;

/// Each wheel lays down so much more or less than it counts, every tick (σ).
const BELIEVED_SLIP: f64 = 0.02;
/// What is left to doubt at the start, m and rad (σ).
const AT_START: f64 = 1e-4;

struct Careful {
    drive: DiffDrive,
    pose_in_world: SE2,
    covariance: Matrix3<f64>,
    last: EncoderCounts,
}

/// Ad: what a twist in one frame is in another.
fn adjoint(motion: SE2) -> Matrix3<f64> {
    let ahead = motion.boxplus(&Vector3::new(1.0, 0.0, 0.0)).translation() - motion.translation();
    let (c, s) = (ahead.x, ahead.y);
    Matrix3::new(c, -s, motion.y(), s, c, -motion.x(), 0.0, 0.0, 1.0)
}

impl Filter for Careful {
    fn update(&mut self, tick: &Tick) -> Reply {
        let moved = odometry_delta(self.last, tick.encoders(), &self.drive);
        self.last = tick.encoders();
        self.pose_in_world = self.pose_in_world.boxplus(&moved);

        let carried = adjoint(SE2::exp(&moved).inverse());
        let half_track_m = 0.5 * self.drive.track_m;
        let slipped_m =
            [-1.0, 1.0].map(|side| BELIEVED_SLIP * (moved.x + side * half_track_m * moved.z));
        let by_wheel =
            [self.drive.tangent(slipped_m[0], 0.0), self.drive.tangent(0.0, slipped_m[1])];
        let slip: Matrix3<f64> = by_wheel.iter().map(|w| w * w.transpose()).sum();
        self.covariance = carried * self.covariance * carried.transpose() + slip;

        let mut row_by_row = [0.0; 9];
        row_by_row.copy_from_slice(self.covariance.transpose().as_slice());
        Estimate::new(self.pose_in_world).with_covariance(row_by_row).into()
    }
}

fn main() -> Exit {
    rusty_clients::run(|start, ()| {
        Ok(Careful {
            drive: start.robot.drive,
            pose_in_world: start.initial_pose.unwrap_or_default(),
            covariance: Matrix3::identity() * (AT_START * AT_START),
            last: EncoderCounts::default(),
        })
    })
}
