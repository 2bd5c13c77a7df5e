//! What determines a run: robot, LiDAR, script, world, seed, time.
//!
//! Every field carries its unit in its name, every default is a number (none
//! of them reads the machine), and every check names field, value and remedy.

mod check;
mod event;
mod fleet;
mod kidnapping;
mod lidar;
mod people;
mod robot;
mod run;
mod script;
pub mod sensors;
mod slip;

pub use check::{FieldError, seconds as check_seconds, within as check_within};
pub(crate) use check::{at_least, seconds, within};
pub use event::Event;
pub use fleet::{Fleet, MAX_ROBOTS, OtherRobot, robot_seed};
pub use kidnapping::Kidnapping;
pub use lidar::LidarConfig;
pub use people::{CrowdConfig, MAX_PEOPLE, Shape, WalkerConfig};
pub use robot::{NominalRobot, RobotConfig};
pub use run::RunConfig;
pub(crate) use run::check_times_and_start;
pub use script::{MAX_COMMANDS, PatrolConfig, ScriptConfig, parse_commands};
pub use sensors::Sensors;
pub use slip::{PatchConfig, SlipFigures};
