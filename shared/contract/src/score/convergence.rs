//! When an estimator has found the robot, and found it again.

use serde::{Deserialize, Serialize};

/// What counts as found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Within {
    /// Position error at most, m.
    pub position_m: f64,
    /// Heading error at most, rad.
    pub heading_rad: f64,
    /// For at least so long without interruption, s.
    pub hold_s: f64,
}

impl Default for Within {
    /// A quarter of a metre and 10°, for a second.
    fn default() -> Self {
        Self { position_m: 0.25, heading_rad: 10f64.to_radians(), hold_s: 1.0 }
    }
}

/// When an estimator has found the robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Convergence {
    /// What counts as found.
    pub within: Within,
    /// From the start of the run to the first scored tick of the first hold, s;
    /// `None`: never.
    pub after_s: Option<f64>,
    /// Rmse of the position from there to the end, m, ticks between a
    /// kidnapping and the recovery left out.
    pub position_rmse_m: Option<f64>,
    /// The same for the heading, rad.
    pub heading_rmse_rad: Option<f64>,
    /// One per kidnapping, in order.
    #[serde(default)]
    pub recoveries: Vec<Recovery>,
}

/// What became of an estimator after the robot was carried away.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recovery {
    /// The tick at whose start the robot was put elsewhere.
    pub kidnapped_at_tick: u64,
    /// From there to the first scored tick of the next hold, s; `None`: never,
    /// or not before the next kidnapping.
    pub after_s: Option<f64>,
}
