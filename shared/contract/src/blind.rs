//! Blind logs: frames to hand out, and the key that stays at home.
//!
//! Sealing splits a log in two. The *blind log* has the same frames (their
//! observable bytes, with one exception: the flag that a truth is known is 0),
//! the same stamps and replies, and a header without what the frames do not
//! show. The [`BlindKey`] has the rest: the header as it was, and the truths.
//!
//! | in the header   | becomes                                                           |
//! |-----------------|-------------------------------------------------------------------|
//! | `source`        | [`Source::Blind`]: no name of a file, no remarks, no findings      |
//! | `seed`          | 0, and no seed is told                                            |
//! | `robot`         | the nominal robot: no slip, no bias                               |
//! | `lidar`, `sensors` | as at the start; with the figures of their data sheets, unless a participant that answers was given the true ones |
//! | `script`        | an empty list: a plan says where the robot was to be              |
//! | `start`         | the origin, unless a participant that answers was told the initial pose |
//! | `world`         | no walls, unless a participant that answers was given the map, and there is one |
//!
//! Name of the scenario, roster with its commands, time step and number of ticks
//! stay. So do the commands as applied: they are in the frames. With a script that
//! steers on the truth, who knows the script computes the truth from them; and who
//! knows scenario and seed, or finds a small seed by trying, makes the run again.

mod key;

pub use key::{BlindKey, BlindKeyError, KeyTick};

use rusty_geometry::{SE2, WorldSpec};

use crate::config::{RobotConfig, ScriptConfig};
use crate::data_sheet::DataSheet;
use crate::log::{LogHeader, RECORDING, Source};
use crate::scenario::{Access, Participant};

/// What the readers of a blind log are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Told {
    /// The initial pose.
    pub initial_pose: Access,
    /// The walls.
    pub map: Access,
}

impl Told {
    /// Returns what a participant that answers was told already.
    #[must_use]
    pub fn of(header: &LogHeader) -> Self {
        let given = |what: fn(&Participant) -> Access| {
            let any = header.answering().any(|p| what(p) == Access::Given);
            if any { Access::Given } else { Access::Hidden }
        };
        Self { initial_pose: given(|p| p.initial_pose), map: given(|p| p.map) }
    }
}

/// The header of the blind log of a log with this header, whose frames have
/// this number and observable digest (hexadecimal). A header that is blind stays
/// as it is.
#[must_use]
pub fn blind_header(
    header: &LogHeader,
    told: Told,
    (observable_digest, ticks): (String, u64),
    writer: &str,
) -> LogHeader {
    let of = match &header.source {
        Source::Simulated | Source::Forked { .. } => "simulation".to_owned(),
        Source::Recorded { .. } => RECORDING.to_owned(),
        Source::Blind { .. } => return header.clone(),
    };
    let start_known = told.initial_pose == Access::Given;
    let world_known = told.map == Access::Given && header.known_world().is_some();
    let mut config = header.config.clone();
    config.seed = 0;
    let figures_known =
        of == RECORDING || header.answering().any(|p| p.data_sheet == DataSheet::Given);
    let sheet = if figures_known { DataSheet::Given } else { DataSheet::Nominal };
    let (lidar, sensors) = header.sheets(sheet);
    (config.lidar, config.sensors) = (lidar.believed(&config.lidar), sensors.believed());
    config.remove_slip();
    config.robot = RobotConfig { radius_bias_right: 0.0, track_bias: 0.0, ..config.robot };
    config.script = ScriptConfig::Commands { file: None, list: Vec::new() };
    // Where the robot is put is a truth.
    config.kidnappings = Vec::new();
    // No participant is told what moves in the world.
    config.fleet = None;
    (config.walkers, config.crowd, config.events) = (Vec::new(), None, Vec::new());
    if !start_known {
        config.start = SE2::identity();
    }
    if !world_known {
        let name = "hidden".to_owned();
        config.world = WorldSpec {
            name,
            bounds: [-1.0, -1.0, 1.0, 1.0],
            walls: Vec::new(),
            landmarks: Vec::new(),
        };
    }
    let source =
        Source::Blind { of, observable_digest, ticks, start_known, world_known, figures_known };
    LogHeader { writer: writer.to_owned(), source, config, ..header.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::join::Start;
    use crate::{Kidnapping, Scenario};

    fn header() -> LogHeader {
        let mut scenario = Scenario { seed: 77, ..Scenario::default() };
        scenario.robot.radius_bias_right = 0.01;
        scenario.robot.track_bias = 0.02;
        scenario.robot.slip_std_left = Some(0.04);
        scenario.robot.slip_outlier_rate = 0.01;
        scenario.patches = vec![crate::config::PatchConfig {
            corners: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            slip_std: 0.3,
            slip_outlier_rate: 0.0,
            slip_outlier_factor: 10.0,
        }];
        scenario.crowd = Some(crate::config::CrowdConfig::default());
        scenario.events = vec![crate::config::Event::OpenDoor { tick: 3, door: 1 }];
        scenario.walkers = vec![crate::config::WalkerConfig {
            waypoints: vec![[1.5, 2.5]],
            speed_m_s: 1.0,
            radius_m: 0.25,
            shape: crate::config::Shape::Disc,
        }];
        scenario.kidnappings = vec![Kidnapping { tick: 5, to: SE2::new(2.5, 3.125, 0.1875) }];
        LogHeader::simulated("test", &scenario, rusty_geometry::places::apartment().spec().clone())
    }

    fn blind(header: &LogHeader) -> LogHeader {
        blind_header(header, Told::of(header), ("0".repeat(32), 9), "sealer")
    }

    fn told(header: &LogHeader) -> Start {
        Start::new(header, 0, &header.roster[0])
    }

    #[test]
    fn of_a_fork_the_lidar_is_told_as_it_was_at_the_start() {
        let before = header().config;
        let mut forked = header();
        let source = Source::Forked { at_tick: 5, before: Box::new(before.clone()) };
        forked.source = source;
        forked.config.lidar.dropout = 0.375;
        forked.config.seed = 9_876_543_210;
        forked.roster[0].data_sheet = DataSheet::Given;
        assert_eq!(told(&forked).lidar, before.lidar.into());
        let blinded = blind(&forked);
        assert_eq!(told(&blinded), told(&forked));
        let json = serde_json::to_string(&blinded).unwrap();
        assert!(!json.contains("0.375") && !json.contains("9876543210"), "{json}");
        let json = serde_json::to_string(&forked).unwrap();
        assert_eq!(serde_json::from_str::<LogHeader>(&json).unwrap(), forked);
    }

    /// The bounds of a recording are those of its true path.
    #[test]
    fn of_a_recording_nobody_is_told_how_far_its_path_went() {
        let mut recorded = header();
        recorded.source = Source::Recorded {
            format: "carmen".to_owned(),
            file: "x.log".to_owned(),
            remarks: Vec::new(),
            findings: Vec::new(),
        };
        assert!(told(&recorded).map.is_some(), "these walls are told");
        recorded.config.world.walls.clear();
        recorded.config.world.landmarks.clear();
        recorded.config.world.bounds = [-17.625, 2.0, 3.0, 4.0];
        assert_eq!(told(&recorded).map, None);
        let blinded = blind(&recorded);
        assert_eq!(told(&blinded), told(&recorded));
        assert!(!serde_json::to_string(&blinded).unwrap().contains("17.625"));
    }

    #[test]
    fn who_was_told_is_told_again_and_nobody_else() {
        let open = header();
        let blinded = blind(&open);
        assert_eq!(blinded.seed(), None);
        assert_eq!(blinded.config.seed, 0);
        let moving =
            (&blinded.config.walkers[..], blinded.config.crowd, &blinded.config.events[..]);
        assert_eq!(moving, (&[][..], None, &[][..]));
        let robot = blinded.config.robot;
        let hidden = (robot.slip_std, robot.radius_bias_right, robot.track_bias);
        assert_eq!(hidden, (0.0, 0.0, 0.0));
        assert_eq!((robot, blinded.config.slips()), (robot.without_slip(), false));
        assert_eq!(robot.nominal(), open.config.robot.nominal());
        assert_eq!(told(&blinded), told(&open));

        let mut hidden = header();
        hidden.roster[0].initial_pose = Access::Hidden;
        hidden.roster[0].map = Access::Hidden;
        let mut blinded = blind(&hidden);
        assert_eq!(blinded.config.start, SE2::identity());
        assert!(blinded.config.world.walls.is_empty() && blinded.config.world.check().is_ok());
        assert_eq!(told(&blinded), told(&hidden));
        // A participant that comes later cannot be told either.
        blinded.roster[0].initial_pose = Access::Given;
        blinded.roster[0].map = Access::Given;
        let start = told(&blinded);
        assert_eq!((start.map, start.initial_pose), (None, None));
        let again = blind_header(&blinded, Told::of(&open), ("1".repeat(32), 8), "again");
        assert_eq!(again, blinded);
    }
}
