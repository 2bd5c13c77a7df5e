//! The world: walls that stand still, and the three questions asked of them.
//!
//! How far does a ray go ([`World::raycast`]), how far is the nearest wall
//! ([`World::distance_to_nearest`]), and does a moving disc touch one
//! ([`World::blocks`], in [`crate::sweep`]).
//!
//! Source: the online *Probabilistic Robotics*, chapter 4, "The world": exact
//! segments, never a grid, in a bounding volume hierarchy that is built once.
//! Departures: the ray formula is our own and watertight (see [`crate::wall`]),
//! where the chapter calls the library's segment cast; ties between walls are
//! decided by index, so that the answer does not depend on the tree.

use nalgebra::{Point2, Vector2};

use crate::material::Material;
use crate::trig;
use crate::wall::Wall;
use crate::wall_blocks::Blocks;
use crate::wall_tree::WallTree;
use crate::world_error::WorldError;
use crate::world_spec::WorldSpec;

/// What a ray met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance from the origin in metres; the maximum asked for if nothing was
    /// met within it.
    pub distance_m: f64,
    /// What was met, or `None`.
    pub material: Option<Material>,
}

/// A checked, immutable world with its search tree.
#[derive(Clone, Debug)]
pub struct World {
    spec: WorldSpec,
    walls: Vec<Wall>,
    tree: WallTree,
    blocks: Blocks,
}

impl World {
    /// Checks `spec` and builds the tree, in O(n log n) for n walls.
    ///
    /// # Errors
    /// Whatever [`WorldSpec::check`] finds.
    pub fn new(spec: WorldSpec) -> Result<Self, WorldError> {
        spec.check()?;
        let walls = spec.to_walls();
        let tree = WallTree::new(&walls);
        let blocks = Blocks::new(&walls);
        Ok(Self { spec, walls, tree, blocks })
    }

    /// The same world with other walls: doors that are open, boxes on its floor.
    /// What it was given stays as it was. Each wall must be finite and of some length;
    /// gaps between them are not looked for.
    #[must_use]
    pub fn with_walls(&self, walls: Vec<Wall>) -> Self {
        let (tree, blocks) = (WallTree::new(&walls), Blocks::new(&walls));
        Self { spec: self.spec.clone(), walls, tree, blocks }
    }

    /// The world as it was given.
    #[must_use]
    pub fn spec(&self) -> &WorldSpec {
        &self.spec
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.spec.name
    }

    /// `[x_min, y_min, x_max, y_max]` in metres. For drawing and for choosing
    /// start poses: the bounds stop neither a ray nor a body.
    #[must_use]
    pub fn bounds(&self) -> [f64; 4] {
        self.spec.bounds
    }

    /// The walls in file order, world frame.
    #[must_use]
    pub fn walls(&self) -> &[Wall] {
        &self.walls
    }

    /// Whether there is no wall at all.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.walls.is_empty()
    }

    /// The first wall along the ray from `origin` (metres, world frame) at
    /// `angle_rad` from the world x axis, no farther than `max_m`.
    ///
    /// A wall at exactly `max_m` is met. An origin on a wall reads 0. Arguments
    /// that are not finite (`max_m` may be infinite) meet nothing.
    #[must_use]
    pub fn raycast(&self, origin: Point2<f64>, angle_rad: f64, max_m: f64) -> Hit {
        let (s, c) = trig::sin_cos(angle_rad);
        self.raycast_dir(origin, Vector2::new(c, s), max_m)
    }

    /// [`World::raycast`] along a unit vector, for callers that turn a table of
    /// directions. The length of `unit_dir` must be 1 up to rounding; it is not
    /// checked.
    #[must_use]
    pub fn raycast_dir(&self, origin: Point2<f64>, unit_dir: Vector2<f64>, max_m: f64) -> Hit {
        match self.first_wall(origin, unit_dir, max_m) {
            Some((distance_m, index)) => {
                Hit { distance_m, material: Some(self.walls[index].material) }
            }
            None => Hit { distance_m: max_m, material: None },
        }
    }

    /// Distance in metres and index of the first wall along a ray, as
    /// [`World::raycast_dir`] finds it: the nearest, at equal distance the one
    /// with the lowest index; the same bits as asking every wall in turn.
    #[must_use]
    pub fn first_wall(
        &self,
        origin: Point2<f64>,
        unit_dir: Vector2<f64>,
        max_m: f64,
    ) -> Option<(f64, usize)> {
        let finite = origin.x.is_finite()
            && origin.y.is_finite()
            && unit_dir.x.is_finite()
            && unit_dir.y.is_finite();
        if !finite {
            return None;
        }
        self.tree.first_along(&self.walls, &origin, &unit_dir, max_m)
    }

    /// The wall that a ray meets after `passed`, a hit of the same ray: the next in
    /// the order of [`World::first_wall`], by distance and then by index, so that
    /// every wall on the ray comes once. `unit_dir` must be finite.
    #[must_use]
    pub fn next_wall(
        &self,
        origin: Point2<f64>,
        unit_dir: Vector2<f64>,
        max_m: f64,
        passed: (f64, usize),
    ) -> Option<(f64, usize)> {
        self.tree.first_of(&self.walls, &origin, &unit_dir, max_m, |hit| hit > passed)
    }

    /// Distance in metres from `point` (world frame) to the nearest wall;
    /// infinite in an open world, NaN for a point that is not finite.
    #[must_use]
    pub fn distance_to_nearest(&self, point: Point2<f64>) -> f64 {
        if !(point.x.is_finite() && point.y.is_finite()) {
            return f64::NAN;
        }
        self.tree.least_distance_squared(&self.walls, &point).sqrt()
    }

    /// The least of `measure` over the walls, square metres, and `most` where none
    /// is below it. A wall's measure is the square of a distance of one of its
    /// points from `point`, so never below that of the nearest; `None` leaves the
    /// wall out. Walls that are farther than the least so far are not asked.
    #[must_use]
    pub fn least_squared(
        &self,
        point: Point2<f64>,
        most: f64,
        measure: impl Fn(&Wall) -> Option<f64>,
    ) -> f64 {
        if !(point.x.is_finite() && point.y.is_finite()) {
            return most;
        }
        self.tree.least_by(&self.walls, &point, most, |index| measure(&self.walls[index]))
    }

    /// [`World::least_squared`] of the walls that reach into a wedge with its tip at
    /// `tip`, given the inward unit normals of its two sides: `measure` must be `None`
    /// for all others, and most of those are not asked.
    #[must_use]
    pub fn least_squared_in_wedge(
        &self,
        tip: Point2<f64>,
        inward: &[Vector2<f64>; 2],
        most: f64,
        measure: impl Fn(&Wall) -> Option<f64>,
    ) -> f64 {
        if !(tip.x.is_finite() && tip.y.is_finite()) {
            return most;
        }
        let measure = |index: usize| measure(&self.walls[index]);
        self.tree.least_in_wedge_by(&self.walls, &tip, inward, most, measure)
    }

    /// Calls `visit` with index and wall of every wall whose box, larger by a small
    /// margin, comes within `reach_m` of `point` along both axes. The order is that of
    /// the tree.
    pub fn visit_near(
        &self,
        point: Point2<f64>,
        reach_m: f64,
        mut visit: impl FnMut(usize, &Wall),
    ) {
        let _ = self.tree.any_near(&point, reach_m, |index| {
            visit(index, &self.walls[index]);
            false
        });
    }

    /// The search tree, for the other queries of this crate.
    pub(crate) fn tree(&self) -> &WallTree {
        &self.tree
    }

    /// The walls as a scan takes them.
    pub(crate) fn wall_blocks(&self) -> &Blocks {
        &self.blocks
    }
}
