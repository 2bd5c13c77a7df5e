//! The robot and its run, as far as a stream of messages tells of them.

use rusty_contract::data_sheet::{DataSheet, LidarSheet, SensorSheets};
use rusty_contract::{LogHeader, Role, Start};
use rusty_geometry::{DiffDrive, SE2, WorldSpec};

/// A robot and its run.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// Wheels and encoders.
    pub drive: DiffDrive,
    /// Length of a tick, s.
    pub dt_s: f64,
    /// One scan every N ticks; 0: none, or at any tick.
    pub scan_every: u64,
    /// Geometry of the LiDAR.
    pub lidar: LidarSheet,
    /// Geometry of the small sensors.
    pub sensors: SensorSheets,
    /// Where the robot starts, world frame, where it is known.
    pub start: Option<SE2>,
    /// Walls and landmarks, where they are known.
    pub world: Option<WorldSpec>,
    /// The commands are known.
    pub has_commands: bool,
    /// Names of the participants that answer, in roster order.
    pub estimators: Vec<String>,
    /// Index of the one whose estimates move `odom` in `map`. `None`: that frame is left
    /// to another program, as SLAM needs it.
    pub localizer: Option<usize>,
    /// True poses are sent.
    pub truth: bool,
}

impl Description {
    /// Returns what a log with this header tells, without true poses. The first
    /// estimator is the localizer.
    #[must_use]
    pub fn of(header: &LogHeader) -> Self {
        let (lidar, sensors) = header.sheets(DataSheet::Given);
        let config = header.told();
        let estimators: Vec<String> = header.answering().map(|p| p.name.clone()).collect();
        let localizer = header.answering().position(|p| p.role == Role::Estimator);
        Self {
            drive: config.robot.nominal().drive,
            dt_s: config.dt_s,
            scan_every: config.scan_every,
            lidar,
            sensors,
            start: header.known_start(),
            world: header.known_world().cloned(),
            has_commands: !header.is_recording(),
            localizer: localizer.or(Some(0)),
            estimators,
            truth: false,
        }
    }

    /// Returns what an observer without the key is told: no answers, and walls and start
    /// only where they are given to it.
    #[must_use]
    pub fn of_start(start: &Start) -> Self {
        Self {
            drive: start.robot.drive,
            dt_s: start.dt_s,
            scan_every: start.scan_every,
            lidar: start.lidar,
            sensors: start.sensors.clone(),
            start: start.initial_pose,
            world: start.map.clone(),
            has_commands: true,
            estimators: Vec::new(),
            localizer: Some(0),
            truth: false,
        }
    }
}
