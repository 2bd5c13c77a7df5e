//! The filters everyone compares with.
//!
//! Each is a type in a file of its own, written as its book has it, and a
//! program that takes part in a run (`src/bin`). What they hold about wheels and
//! beams are *beliefs*: the parametrisation of Thrun, Burgard and Fox,
//! *Probabilistic Robotics* (2005), not the physics of the simulator, which this
//! crate cannot name.
//!
//! Everything is deterministic: random numbers come from named streams of a
//! seed on the command line ([`random`]), and transcendental functions from
//! [`rusty_geometry::trig`]. So a filter gives the same answers live, on a log,
//! on a replay, and on another machine. Products of matrices whose size is known
//! only at run time are written out: the library's use whatever instructions the
//! processor has.
//!
//! What they share, in reading order: [`random`]; [`motion`] and [`beams`], what
//! a filter believes of wheels and of the laser's geometry; [`grid`] and
//! [`occupancy`], maps of cells; [`line_fit`], [`lines`] and [`line_map`], straight
//! walls. The filters: [`ekf`]; [`bayes_hallway`] with [`histogram`] and [`corridor`].

pub mod random;

pub mod beams;
pub mod motion;

pub mod grid;
pub mod occupancy;

pub mod line_fit;
pub mod line_map;
pub mod lines;

pub mod ekf;

pub mod bayes_hallway;
pub mod corridor;
pub mod histogram;

pub use beams::Beams;
pub use ekf::Ekf;
pub use grid::GridFrame;
pub use motion::{Motion, Odometry, OdometryNoise};
pub use occupancy::{Cell, OccupancyMap};
pub use random::Random;
