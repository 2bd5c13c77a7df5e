//! Ways over a map of cells: how far walls are, what a way costs, and the way
//! itself.
//!
//! [`clearance`] knows of each cell how far the nearest wall is, [`routes`] finds
//! the cheapest way to anywhere at once, [`mod@straighten`] makes few straight pieces
//! of many steps; [`chart`] is the three together.
//!
//! For a robot with a least turning radius: a [`mod@curve`] consists of arcs and
//! straight pieces, forwards or in reverse; [`mod@reeds_shepp`] finds the shortest one
//! without walls, [`mod@hybrid_a_star`] a cheap one over a chart.

pub mod chart;
pub mod clearance;
pub mod curve;
pub mod hybrid_a_star;
pub mod reeds_shepp;
pub mod routes;
pub mod straighten;

pub use chart::Chart;
pub use clearance::{Clearance, Unknown};
pub use curve::{Curve, Piece};
pub use hybrid_a_star::{Goal, Kinematics, hybrid_a_star};
pub use reeds_shepp::reeds_shepp;
pub use routes::{Room, Routes};
pub use straighten::straighten;
