//! The plane and what is in it.
//!
//! Poses and motions, a robot with two wheels, its encoders, and a world of
//! walls that a ray can meet and a body can run into. Everything is plain
//! arithmetic on `f64`: no clock, no files, no threads, no platform mathematics
//! library, so that one input gives the same bits on every machine and in wasm32.
//!
//! Conventions: metres, radians, seconds; x forward, y left, angles
//! counter-clockwise in (−π, π]; world frame unless a name says otherwise.
//!
//! In reading order: [`trig`], [`normal`], [`normals`], [`angle`], [`se2`]; [`drive`], [`encoders`];
//! [`material`], [`wall`], [`gap`], [`world_spec`], [`world`], [`fan`], [`scan`],
//! [`motion_arc`], [`sweep`], [`places`], [`generated`].
//!
//! The chapter this grew from is chapter 4 of the online *Probabilistic
//! Robotics*, "Rusty, Sensors, and the Simulator".

mod avx2;
pub mod trig;

pub mod normal;
pub mod normals;

pub mod angle;
pub mod se2;

pub mod drive;
pub mod encoders;

pub mod disc;
pub mod exactly;
pub mod fan;
pub mod gap;
pub mod material;
pub mod scan;
pub mod wall;
mod wall_blocks;
mod wall_tree;
pub mod world;
pub mod world_error;
pub mod world_spec;

pub mod motion_arc;
pub mod sweep;

pub mod generated;
pub mod generated_places;
pub mod places;

pub use angle::wrap_angle;
pub use disc::Disc;
pub use drive::{DiffDrive, Twist, WheelRates};
pub use encoders::{EncoderCounts, odometry_delta, tick_length};
pub use fan::Fan;
pub use gap::Gap;
pub use material::{Material, MaterialError};
pub use motion_arc::MotionArc;
pub use places::{PLACES, apartment, hallway, lobby, open, place};
pub use scan::Scan;
pub use se2::SE2;
pub use wall::Wall;
pub use world::{Hit, World};
pub use world_error::WorldError;
pub use world_spec::{Landmark, WallSpec, WorldSpec};
