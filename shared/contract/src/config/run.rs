//! All that determines the bits of a run, but the commands of a driver.

use std::fmt::Debug;

use rusty_geometry::world_spec::MAX_NAME_CHARS;
use rusty_geometry::{Material, SE2, WallSpec, WorldSpec};
use serde::{Deserialize, Serialize};

use super::{
    CrowdConfig, Event, FieldError, Fleet, Kidnapping, LidarConfig, PatchConfig, RobotConfig,
    ScriptConfig, Sensors, WalkerConfig, at_least, within,
};
use crate::json::json_tree;

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
    /// One scan every N ticks, the first in tick 0; 0: no scans.
    pub scan_every: u64,
    /// Where the robot starts, world frame.
    pub start: SE2,
    /// The robot, true parameters included.
    pub robot: RobotConfig,
    /// The LiDAR.
    pub lidar: LidarConfig,
    /// The small sensors.
    #[serde(default, skip_serializing_if = "Sensors::is_none")]
    pub sensors: Sensors,
    /// Where the commands come from.
    pub script: ScriptConfig,
    /// The walls.
    pub world: WorldSpec,
    /// Where the robot is carried away, in the order of the ticks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub kidnappings: Vec<Kidnapping>,
    /// People who walk along waypoints.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub walkers: Vec<WalkerConfig>,
    /// People who walk by social forces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crowd: Option<CrowdConfig>,
    /// What changes in the world, in the order of the ticks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<Event>,
    /// The robot's place among others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fleet: Option<Box<Fleet>>,
    /// Where on the floor the wheels slip otherwise.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub patches: Vec<PatchConfig>,
}

json_tree!(Box<RunConfig>, RunConfig);

impl RunConfig {
    /// Time at the end of tick `tick`, s.
    #[must_use]
    pub fn time_s(&self, tick: u64) -> f64 {
        (tick + 1) as f64 * self.dt_s
    }

    /// Whether the wheels slip, anywhere.
    #[must_use]
    pub fn slips(&self) -> bool {
        let wheels = self.robot.slip_figures();
        let patches = self.patches.iter().map(PatchConfig::figures);
        wheels.into_iter().chain(patches).any(|figures| figures.std != 0.0)
    }

    /// Whether anything in the world may ever move or change but the robots.
    #[must_use]
    pub fn world_moves(&self) -> bool {
        !self.walkers.is_empty() || self.crowd.is_some() || !self.events.is_empty()
    }

    /// The figures of the slip on one line; `unit` is put after σ.
    #[must_use]
    pub fn slip_in_words(&self, unit: &str) -> String {
        let [left, right] = self.robot.slip_figures();
        let mut text = match left.std.to_bits() == right.std.to_bits() {
            true => format!("{}{unit}", left.std),
            false => format!("{} left and {} right{unit}", left.std, right.std),
        };
        if left.outlier_rate > 0.0 {
            text += &format!(", {} % × {}", 100.0 * left.outlier_rate, left.outlier_factor);
        }
        match self.patches.len() {
            0 => text,
            1 => text + ", 1 patch of floor",
            n => format!("{text}, {n} patches of floor"),
        }
    }

    /// Makes the wheels not slip, anywhere.
    pub fn remove_slip(&mut self) {
        self.robot = self.robot.without_slip();
        self.patches.clear();
    }

    /// Whether a run with this configuration can go on with `after` in the
    /// middle. Seed, number of ticks, script, the noise of the LiDAR, the true
    /// parameters of the robot, kidnappings, events and patches may change. What participants rely
    /// on from the start on, and what is past, may not.
    ///
    /// # Errors
    /// [`FieldError`] names the first field that must stay as it was.
    pub fn check_change(&self, after: &Self) -> Result<(), FieldError> {
        let kept = |field: &str, was: &dyn Debug, is: &dyn Debug| {
            // `Debug` of a number tells all its bits but those of a NaN.
            let (was, is) = (format!("{was:?}"), format!("{is:?}"));
            if was == is {
                return Ok(());
            }
            let long = |text: String| text.chars().take(80).collect::<String>();
            let problem = format!("was {} when the run began, and must stay so", long(was));
            let remedy = "start another run with it (`sim-server launch --set …`)";
            Err(FieldError::new(field, long(is), problem, remedy))
        };
        kept("scenario", &self.scenario, &after.scenario)?;
        kept("dt_s", &self.dt_s, &after.dt_s)?;
        kept("scan_every", &self.scan_every, &after.scan_every)?;
        kept("start", &self.start, &after.start)?;
        let (a, b) = (&self.robot, &after.robot);
        kept("robot.wheel_radius_m", &a.wheel_radius_m, &b.wheel_radius_m)?;
        kept("robot.track_m", &a.track_m, &b.track_m)?;
        kept("robot.body_radius_m", &a.body_radius_m, &b.body_radius_m)?;
        kept("robot.ticks_per_rev", &a.ticks_per_rev, &b.ticks_per_rev)?;
        kept("robot.wheel_limit_rad_s", &a.wheel_limit_rad_s, &b.wheel_limit_rad_s)?;
        let (a, b) = (&self.lidar, &after.lidar);
        kept("lidar.beams", &a.beams, &b.beams)?;
        kept("lidar.first_bearing_rad", &a.first_bearing_rad, &b.first_bearing_rad)?;
        kept("lidar.fov_rad", &a.fov_rad, &b.fov_rad)?;
        kept("lidar.range_max_m", &a.range_max_m, &b.range_max_m)?;
        kept("lidar.sensor_in_body", &a.sensor_in_body, &b.sensor_in_body)?;
        kept("sensors", &self.sensors, &after.sensors)?;
        if self.script.is_driver() != after.script.is_driver() {
            // A driver has, or would need, a place in the roster.
            kept("script.kind", &self.script.kind(), &after.script.kind())?;
        }
        kept("walker", &self.walkers, &after.walkers)?;
        kept("crowd", &self.crowd, &after.crowd)?;
        kept("fleet", &self.fleet, &after.fleet)?;
        kept("world", &self.world, &after.world)
    }

    /// Checks the other robots, and that no two start in one place.
    pub(crate) fn check_fleet(&self) -> Result<(), FieldError> {
        let fleet = self.fleet.as_deref();
        fleet.map_or(Ok(()), |fleet| fleet.check(self.start, self.robot.body_radius_m))
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
        check_times_and_start(self.dt_s, self.scan_every, self.start)?;
        self.robot.check()?;
        self.lidar.check()?;
        self.sensors.check()?;
        self.script.check()?;
        Kidnapping::check(&self.kidnappings)?;
        WalkerConfig::check(&self.walkers)?;
        self.crowd.as_ref().map_or(Ok(()), CrowdConfig::check)?;
        Event::check(&self.events)?;
        self.check_fleet()?;
        PatchConfig::check(&self.patches)?;
        self.world.check().map_err(|e| {
            FieldError::new("world", &self.world.name, e.to_string(), "mend the world file")
        })?;
        for (i, event) in self.events.iter().enumerate() {
            let (Event::OpenDoor { door, .. } | Event::CloseDoor { door, .. }) = event else {
                continue;
            };
            let is_there = |wall: &WallSpec| wall.material == Material::Door(*door);
            if !self.world.walls.iter().any(is_there) {
                let problem = format!("is no door of the world {:?}", self.world.name);
                let remedy = "take the number of a wall with material = \"Door(N)\"";
                return Err(FieldError::new(format!("event[{i}].door"), door, problem, remedy));
            }
        }
        Ok(())
    }
}

/// Checks the fields that a scenario and a configuration share outside of robot,
/// LiDAR and script.
pub(crate) fn check_times_and_start(
    dt_s: f64,
    scan_every: u64,
    start: SE2,
) -> Result<(), FieldError> {
    within("dt_s", dt_s, 1e-6, 10.0)?;
    at_least("scan_every", scan_every, 0, 1 << 40)?;
    check_pose("start", start)
}

/// Checks that a pose is near enough to be used.
pub(super) fn check_pose(field: &str, pose: SE2) -> Result<(), FieldError> {
    within(&format!("{field}.x_m"), pose.x(), -1e6, 1e6)?;
    within(&format!("{field}.y_m"), pose.y(), -1e6, 1e6)?;
    within(&format!("{field}.theta_rad"), pose.theta(), -4.0, 4.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::PatrolConfig;

    fn config() -> RunConfig {
        RunConfig {
            scenario: "test".to_owned(),
            seed: 1,
            ticks: 10,
            dt_s: 0.02,
            scan_every: 5,
            start: SE2::new(6.0, 4.5, 0.0),
            robot: RobotConfig::default(),
            lidar: LidarConfig::default(),
            script: ScriptConfig::default(),
            world: rusty_geometry::apartment().spec().clone(),
            sensors: Sensors::default(),
            kidnappings: Vec::new(),
            walkers: Vec::new(),
            crowd: None,
            events: Vec::new(),
            fleet: None,
            patches: Vec::new(),
        }
    }

    fn changed(change: impl Fn(&mut RunConfig)) -> Result<(), FieldError> {
        let mut after = config();
        change(&mut after);
        config().check_change(&after)
    }

    #[test]
    fn all_slip_is_named_and_removed() {
        let mut config = config();
        assert_eq!(config.slip_in_words(" per tick"), "0.02 per tick");
        config.remove_slip();
        assert!(!config.slips());
        config.robot.slip_std_left = Some(0.03);
        assert!(config.slips());
        (config.robot.slip_outlier_rate, config.robot.slip_outlier_factor) = (0.25, 5.0);
        config.patches = vec![PatchConfig {
            corners: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            slip_std: 0.3,
            slip_outlier_rate: 0.0,
            slip_outlier_factor: 10.0,
        }];
        let said = config.slip_in_words("");
        assert_eq!(said, "0.03 left and 0 right, 25 % × 5, 1 patch of floor");
        config.robot.slip_std_left = None;
        assert!(config.slips(), "a patch alone");
        config.remove_slip();
        assert!(!config.slips());
    }

    #[test]
    fn noise_and_script_may_change_in_the_middle_and_what_was_told_may_not() {
        let free: [fn(&mut RunConfig); 14] = [
            |c| c.seed = 2,
            |c| c.ticks = 20,
            |c| c.robot.slip_std = 0.1,
            |c| c.robot.slip_std_left = Some(0.1),
            |c| c.robot.slip_outlier_rate = 0.1,
            |c| c.robot.radius_bias_right = 0.1,
            |c| c.robot.track_bias = 0.1,
            |c| c.lidar.range_std_m = 0.1,
            |c| c.lidar.dropout = 0.1,
            |c| c.lidar.range_std_per_m = 0.1,
            |c| c.lidar.glass_visible_rad = 0.1,
            |c| c.lidar.divergence_rad = 0.1,
            |c| c.kidnappings.push(Kidnapping { tick: 3, to: SE2::identity() }),
            |c| c.script = ScriptConfig::Patrol(PatrolConfig::default()),
        ];
        assert!(free.iter().all(|change| changed(change).is_ok()));
        let kept: [fn(&mut RunConfig); 17] = [
            |c| c.scenario.push('x'),
            |c| c.dt_s = 0.1,
            |c| c.scan_every = 4,
            |c| c.start = SE2::new(6.0, 4.5, -0.0),
            |c| c.robot.wheel_radius_m = 0.034,
            |c| c.robot.track_m = 0.17,
            |c| c.robot.body_radius_m = 0.1,
            |c| c.robot.ticks_per_rev = 4095,
            |c| c.robot.wheel_limit_rad_s = 19.0,
            |c| c.lidar.beams = 181,
            |c| c.lidar.first_bearing_rad = 0.0,
            |c| c.lidar.fov_rad = 3.0,
            |c| c.lidar.range_max_m = 9.0,
            |c| c.lidar.sensor_in_body = SE2::new(0.1, 0.0, 0.0),
            |c| c.script = ScriptConfig::Driver {},
            |c| c.sensors.imu = Some(crate::config::sensors::ImuConfig::default()),
            |c| c.world.walls.truncate(3),
        ];
        for (i, change) in kept.iter().enumerate() {
            assert!(changed(change).is_err(), "change {i}");
        }
        let error = changed(kept[9]).unwrap_err().to_string();
        assert!(error.starts_with("lidar.beams = 181: was 180 when the run began"), "{error}");
    }
}
