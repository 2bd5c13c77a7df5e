//! All that determines the bits of a run, but the commands of a driver.

use rusty_geometry::world_spec::MAX_NAME_CHARS;
use rusty_geometry::{SE2, WorldSpec};
use serde::{Deserialize, Serialize};

use super::{FieldError, LidarConfig, RobotConfig, ScriptConfig, at_least, within};

/// The configuration of a run. A seed, this and the driver's commands
/// determine every frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunConfig {
    /// Name of the scenario it came from.
    pub scenario: String,
    /// The seed of all noise.
    pub seed: u64,
    /// How many ticks the run has.
    pub ticks: u64,
    /// Length of a tick, s.
    pub dt_s: f64,
    /// One scan every so many ticks, the first in tick 0; 0: no scans.
    pub scan_every: u64,
    /// Where the robot starts, world frame.
    pub start: SE2,
    /// The robot, true parameters included.
    pub robot: RobotConfig,
    /// The LiDAR.
    pub lidar: LidarConfig,
    /// Where the commands come from.
    pub script: ScriptConfig,
    /// The walls.
    pub world: WorldSpec,
}

impl RunConfig {
    /// Time at the end of tick `tick`, s.
    #[must_use]
    pub fn time_s(&self, tick: u64) -> f64 {
        (tick + 1) as f64 * self.dt_s
    }

    /// Checks every field, the world included.
    ///
    /// # Errors
    /// [`FieldError`] names the first that cannot be used.
    pub fn check(&self) -> Result<(), FieldError> {
        // It is printed, and a stranger's log may have any.
        let chars = self.scenario.chars().count();
        if chars > MAX_NAME_CHARS || self.scenario.chars().any(char::is_control) {
            let shown: String = self.scenario.chars().take(MAX_NAME_CHARS).collect();
            let remedy = format!("use at most {MAX_NAME_CHARS}, none of them a control character");
            let (value, problem) = (format!("{shown:?}"), format!("has {chars} characters"));
            return Err(FieldError::new("name", value, problem, remedy));
        }
        at_least("ticks", self.ticks, 1, 1 << 40)?;
        within("dt_s", self.dt_s, 1e-6, 10.0)?;
        at_least("scan_every", self.scan_every, 0, 1 << 40)?;
        within("start.x_m", self.start.x(), -1e6, 1e6)?;
        within("start.y_m", self.start.y(), -1e6, 1e6)?;
        within("start.theta_rad", self.start.theta(), -4.0, 4.0)?;
        self.robot.check()?;
        self.lidar.check()?;
        self.script.check()?;
        self.world.check().map_err(|e| {
            FieldError::new("world", &self.world.name, e.to_string(), "mend the world file")
        })
    }
}
