//! Why a simulation cannot begin.

use rusty_contract::FieldError;
use rusty_geometry::WorldError;
use thiserror::Error;

/// Why a simulation cannot begin. Once it has begun, nothing fails.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SimError {
    /// A field of the configuration cannot be used.
    #[error(transparent)]
    Config(#[from] FieldError),
    /// The world cannot be used.
    #[error(transparent)]
    World(#[from] WorldError),
    /// The robot would start, or be put, in a wall, and never leave it: every step of a body
    /// that touches a wall is blocked.
    #[error(
        "{field} = ({x_m}, {y_m}) m in world {world:?}: the body, a disc of radius {body_radius_m} m, \
         touches a wall that is {distance_m:.6} m away; move it at least {missing_m:.6} m \
         away from that wall, or make robot.body_radius_m smaller than that distance"
    )]
    StartInWall {
        /// `start`, or the kidnapping that puts it there.
        field: String,
        /// Name of the world.
        world: String,
        /// World x of the start, m.
        x_m: f64,
        /// World y of the start, m.
        y_m: f64,
        /// Radius of the body, m.
        body_radius_m: f64,
        /// Distance from the start to the nearest wall, m.
        distance_m: f64,
        /// By how much that is too little, m.
        missing_m: f64,
    },
}
