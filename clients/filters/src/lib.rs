//! The filters everyone compares with.
//!
//! Each is a type in a separate file, written as its book has it, and a
//! program that takes part in a run (`programs`). What they hold about wheels and
//! beams are *beliefs*: the parametrisation of Thrun, Burgard and Fox,
//! *Probabilistic Robotics* (2005), not the physics of the simulator, which this
//! crate cannot name.
//!
//! Everything is deterministic: random numbers come from named streams of a
//! seed on the command line ([`Random`]), and transcendental functions from
//! [`rusty_geometry::trig`]. So a filter gives the same answers live, on a log,
//! on a replay, and on another machine. Products of matrices whose size is known
//! only at run time are written out: the library's use whatever instructions the
//! processor has.
//!
//! What they share, in reading order: [`motion`], [`beams`]
//! and [`beam_model`], what a filter believes of wheels, of the laser's geometry and
//! of its readings; [`grid`], [`occupancy`] and [`distance_field`], maps of cells,
//! and [`map_server`], the files they are kept in; [`tangent`], covariances of poses.
//!
//! The filters: [`ekf`], on straight walls ([`line_fit`], [`lines`], [`line_map`]);
//! [`mcl`], on particles ([`likelihood_field`], [`resampling`], [`kld`]);
//! [`grid_localisation`], on cells over position and heading;
//! [`scan_match`], on [`icp`] and wheels that learn their errors ([`calibration`]);
//! [`slam`], on it and a [`pose_graph`] ([`sparse`]); [`gridmap`], on an
//! [`occupancy_grid`] ([`ray_walk`], [`map_picture`]); [`bayes_hallway`], on a
//! [`histogram`] and what a [`corridor`] shows.
//!
//! The filters of landmarks, on the model and association of [`landmarks`]:
//! [`ekf_landmarks`] and [`eif_landmarks`] on a given map; [`ekf_slam`] and [`fastslam`]
//! make one.
//!
//! The drivers: [`driver`] is the loop of all. [`surroundings`] keeps a robot off the
//! walls, [`steering`] finds a free way; [`wander`] needs no more than [`reckoning`].
//! [`planning`] finds ways over a map, [`pilot`] follows them by [`pursuit`] or in the
//! [`dynamic_window`], and curves by [`curve_pursuit`]: [`goto`] on a map that is given,
//! [`explore`] on one that it makes ([`graph_map`]), to its [`frontiers`].
//!
//! [`trajectory`] answers with the poses of an estimator that ran elsewhere.
//!
//! The numbers of the models, from logs: [`fit_beam`], [`fit_motion`].

mod numbers;
#[cfg(test)]
mod told_tests;

pub mod beam_model;
pub mod beams;
pub mod moment;
pub mod motion;

pub mod distance_field;
pub mod grid;
#[cfg(feature = "link")]
pub mod map_server;
pub mod occupancy;
pub mod tangent;

pub mod ekf;
pub mod line_fit;
pub mod line_map;
pub mod lines;

pub mod grid_localisation;
mod held;
pub mod kld;
pub mod likelihood_field;
pub mod mcl;
pub mod resampling;

pub mod eif_landmarks;
pub mod ekf_landmarks;
pub mod ekf_slam;
pub mod fastslam;
pub mod landmarks;
pub mod start_options;

pub mod calibration;
pub mod icp;
pub mod scan_match;

pub mod pose_graph;
#[cfg(feature = "link")]
pub mod slam;
pub mod sparse;
pub mod submap;

#[cfg(feature = "link")]
pub mod gridmap;
#[cfg(feature = "link")]
pub mod map_picture;
pub mod occupancy_grid;
pub mod ray_walk;

pub mod bayes_hallway;
pub mod corridor;
pub mod curve_pursuit;
pub mod histogram;

pub mod driver;
pub mod dynamic_window;
pub mod reckoning;
pub mod steering;
pub mod surroundings;
pub mod wander;

pub mod goto;
pub mod graph_map;
pub mod pilot;
pub mod planning;
pub mod pursuit;

#[cfg(feature = "link")]
pub mod explore;
pub mod frontiers;

#[cfg(feature = "link")]
pub mod trajectory;

#[cfg(feature = "link")]
pub mod fit_beam;
#[cfg(feature = "link")]
pub mod fit_motion;

#[cfg(feature = "link")]
mod programs;
mod pyramid;

pub use beam_model::BeamModel;
pub use beams::Beams;
pub use distance_field::DistanceField;
pub use ekf::Ekf;
pub use grid::GridFrame;
pub use likelihood_field::LikelihoodField;
pub use motion::{Motion, Odometry, OdometryNoise};
pub use occupancy::{Cell, OccupancyMap};
pub use occupancy_grid::OccupancyGrid;
#[cfg(feature = "link")]
pub use programs::PROGRAMS;
pub use rusty_clients::Random;
