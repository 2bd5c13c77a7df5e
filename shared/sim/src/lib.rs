//! The world: a pure function of a configuration and of commands.
//!
//! [`Sim`] holds a robot in a place and moves it tick by tick: command, wheels,
//! slip, walls, encoders, LiDAR. It reads no clock, no file and no environment,
//! starts no thread and knows nothing of how its frames travel, so the same
//! configuration, seed and commands give the same bits in every build, on every
//! machine and in wasm32.
//!
//! In reading order:
//!
//! * [`noise`]: where every random number comes from, and why a change in one
//!   place reshuffles nothing in another;
//! * [`outcome`], [`robot`], [`slip`]: one tick of a differential drive that slips;
//! * [`lidar`]: one scan;
//! * [`patrol`], [`steering`], [`script`]: where commands come from;
//! * [`sim_error`], [`sim`]: all of it together;
//! * [`record`](mod@record): a whole run as a log, without a server;
//! * [`golden`]: runs whose digests are constants.
//!
//! Units are metres, radians and seconds; poses are in the world frame and
//! twists in the body frame unless a name says otherwise. The algorithms are
//! those of chapter 4 of the online *Probabilistic Robotics*, "Rusty, Sensors,
//! and the Simulator"; each module states where it departs from it.
//!
//! ```
//! use rusty_contract::{Frame, LidarConfig, RobotConfig, RunConfig, ScriptConfig};
//! use rusty_geometry::{SE2, Twist, apartment};
//! use rusty_sim::{Sim, StepOutcome};
//!
//! let config = RunConfig {
//!     scenario: "example".into(),
//!     seed: 7,
//!     ticks: 50,
//!     dt_s: 0.02,
//!     scan_every: 5,
//!     start: SE2::new(6.0, 4.5, 0.0),
//!     robot: RobotConfig::default(),
//!     lidar: LidarConfig::default(),
//!     script: ScriptConfig::Driver {},
//!     world: apartment().spec().clone(),
//!     sensors: rusty_contract::Sensors::default(),
//!     kidnappings: Vec::new(),
//!     walkers: Vec::new(),
//!     crowd: None,
//!     events: Vec::new(),
//!     fleet: None,
//!     patches: Vec::new(),
//! };
//! let mut sim = Sim::new(config)?;
//! let mut frame = Frame::boxed();
//! let forward = Twist { v_m_s: 0.5, omega_rad_s: 0.0 };
//! for _ in 0..50 {
//!     let outcome = sim.step(Some(forward), &mut frame);
//!     assert!(matches!(outcome, StepOutcome::Moved { .. }));
//! }
//! assert_eq!(sim.tick(), 50);
//! assert_eq!(frame.tick(), 49);
//! assert!((sim.truth().x() - 6.5).abs() < 0.05);
//! assert!(frame.ranges_m().is_none(), "tick 49 is no multiple of 5");
//! # Ok::<(), rusty_sim::SimError>(())
//! ```

pub mod noise;

pub mod outcome;
pub mod robot;
pub mod slip;

mod events;
mod fleet;
pub mod lidar;
pub mod people;
pub mod scene;
pub mod sensors;

pub mod patrol;
pub mod steering;

pub mod script;

pub mod sim_error;

pub mod sim;

pub mod record;

pub mod golden;

pub use golden::{GOLDENS, Golden};
pub use lidar::Lidar;
pub use outcome::StepOutcome;
pub use record::record;
pub use robot::Robot;
pub use script::{BuiltInScript, Moment, Script};
pub use sim::Sim;
pub use sim_error::SimError;
