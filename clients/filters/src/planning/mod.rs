//! Ways over a map of cells: how far walls are, what a way costs, and the way
//! itself.
//!
//! [`clearance`] knows of each cell how far the nearest wall is, [`routes`] finds
//! the cheapest way to anywhere at once, [`mod@straighten`] makes few straight pieces
//! of many steps; [`chart`] is the three together.

pub mod chart;
pub mod clearance;
pub mod routes;
pub mod straighten;

pub use chart::Chart;
pub use clearance::{Clearance, Unknown};
pub use routes::{Room, Routes};
pub use straighten::straighten;
