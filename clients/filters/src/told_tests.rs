//! What a filter is told of a run that a test drives by hand.

use rusty_contract::data_sheet::SensorSheets;
use rusty_contract::{DataSheet, LidarConfig, NominalRobot, Role, Start};
use rusty_geometry::DiffDrive;

/// Nothing is given, of walls or of where it starts; a scan every fifth tick of
/// 0.02 s.
pub(crate) fn told(name: &str) -> Start {
    Start {
        run_id: 0,
        scenario: "by hand".to_owned(),
        participant: 0,
        name: name.to_owned(),
        ticket: 0,
        catch_up: None,
        role: Role::Estimator,
        awaited: true,
        server_pid: 0,
        ticks: 0,
        dt_s: 0.02,
        scan_every: 5,
        robot: NominalRobot {
            drive: DiffDrive::rusty(),
            body_radius_m: 0.11,
            wheel_limit_rad_s: 20.0,
        },
        data_sheet: DataSheet::Given,
        lidar: LidarConfig::default().into(),
        map: None,
        initial_pose: None,
        server_awake_ns: 0,
        check_frames: false,
        sealed_brief: None,
        more_runs: false,
        run_number: 0,
        sensors: SensorSheets::default(),
    }
}
