//! What a robot and its sensors meet: walls that stand still, and bodies that move.

use nalgebra::{Point2, Vector2};
use rusty_geometry::{Disc, SE2, World};

/// The walls and the bodies of a tick.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// The walls.
    pub world: &'a World,
    /// The bodies: people, or their legs.
    pub bodies: &'a [Disc],
}

impl<'a> From<&'a World> for Scene<'a> {
    /// Walls alone.
    fn from(world: &'a World) -> Self {
        Self { world, bodies: &[] }
    }
}

impl Scene<'_> {
    /// Whether a disc of `radius_m` touches anything on its way from `from` to `to`;
    /// see [`World::blocks`].
    #[must_use]
    pub fn blocks(&self, from: &SE2, to: &SE2, radius_m: f64) -> bool {
        self.world.blocks(from, to, radius_m)
            || self.bodies.iter().any(|body| body.blocks(from, to, radius_m))
    }

    /// Whether anything is nearer than `distance_m` along a ray.
    #[must_use]
    pub fn hides(&self, origin: Point2<f64>, unit_dir: Vector2<f64>, distance_m: f64) -> bool {
        self.world.first_wall(origin, unit_dir, distance_m).is_some()
            || self
                .bodies
                .iter()
                .any(|body| body.cast(&origin, &unit_dir).is_some_and(|m| m < distance_m))
    }
}
