//! Worlds of any size, made from a seed: for measuring, and for tests.
//!
//! Two patterns. *Rooms* is a grid of square rooms whose sides are whole walls,
//! walls with a door, or open, as in a building that goes on and on. *Segments*
//! has one free-standing wall of random length and direction in each cell of a
//! grid, with room to look through between them.
//!
//! Two ways to grow. At *constant* density the area grows with the number of
//! walls and what can be seen from a place stays the same; on a constant *area*
//! the walls become shorter and denser.
//!
//! Portable arithmetic, so a recipe gives the same bits everywhere; every world
//! passes [`WorldSpec::check`].

use nalgebra::Point2;

use crate::material::Material;
use crate::se2::SE2;
use crate::trig;
use crate::world::World;
use crate::world_spec::{WallSpec, WorldSpec};

/// Side of a room at constant density, metres.
const ROOM_M: f64 = 3.0;
/// Side of the cell of a free-standing wall at constant density, metres.
const CELL_M: f64 = 1.5;
/// Side of the whole world at constant area, metres.
const SIDE_M: f64 = 64.0;
/// Free space between a free-standing wall and the border of its cell, metres:
/// two walls are farther apart than what counts as a gap.
const MARGIN_M: f64 = 0.03;

/// How the walls stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// A grid of rooms with doors.
    Rooms,
    /// Free-standing walls in all directions.
    Segments,
}

/// What stays the same when there are more walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Density {
    /// Walls per area: rooms of 3 m, or a free-standing wall each 1.5 m.
    Constant,
    /// The area: 64 m × 64 m.
    Area,
}

/// What a world is made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Recipe {
    /// How the walls stand.
    pub pattern: Pattern,
    /// What stays the same when there are more.
    pub density: Density,
    /// How many walls, exactly.
    pub walls: usize,
    /// Seed of everything that is left to chance.
    pub seed: u64,
}

impl Recipe {
    /// The world that this recipe makes. It is no closed building: rays leave it
    /// through its upper and its right side, and where a side is open.
    ///
    /// ```
    /// use rusty_geometry::generated::{Density, Pattern, Recipe};
    /// use rusty_geometry::World;
    /// let recipe = Recipe {
    ///     pattern: Pattern::Rooms,
    ///     density: Density::Constant,
    ///     walls: 512,
    ///     seed: 1,
    /// };
    /// assert_eq!(World::new(recipe.spec())?.walls().len(), 512);
    /// # Ok::<(), rusty_geometry::WorldError>(())
    /// ```
    #[must_use]
    pub fn spec(&self) -> WorldSpec {
        let mut dice = Dice::new(self.seed);
        let (walls, rows) = match self.pattern {
            Pattern::Rooms => self.rooms(&mut dice),
            Pattern::Segments => self.segments(&mut dice),
        };
        let (columns, cell_m) = (self.columns(), self.cell_m());
        let bounds = [0.0, 0.0, cell_m * columns as f64, cell_m * rows as f64];
        WorldSpec { name: self.name(), bounds, walls, landmarks: Vec::new() }
    }

    /// What the world is called, for example `rooms-constant-512`.
    #[must_use]
    pub fn name(&self) -> String {
        let pattern = match self.pattern {
            Pattern::Rooms => "rooms",
            Pattern::Segments => "segments",
        };
        let density = match self.density {
            Density::Constant => "constant",
            Density::Area => "area",
        };
        format!("{pattern}-{density}-{}", self.walls)
    }

    /// Cells in a row, so that there are about as many rows. A room owns its
    /// lower and its left side, which come to 11/4 walls on average.
    fn columns(&self) -> usize {
        let cells = match self.pattern {
            Pattern::Rooms => (self.walls * 4).div_ceil(11),
            Pattern::Segments => self.walls,
        };
        let root = cells.isqrt();
        if root * root < cells { root + 1 } else { root.max(1) }
    }

    /// Side of a cell, metres.
    fn cell_m(&self) -> f64 {
        match (self.density, self.pattern) {
            (Density::Area, _) => SIDE_M / self.columns() as f64,
            (Density::Constant, Pattern::Rooms) => ROOM_M,
            (Density::Constant, Pattern::Segments) => CELL_M,
        }
    }

    /// Lower and left sides of rooms, row by row, until there are enough walls;
    /// and the number of rows.
    fn rooms(&self, dice: &mut Dice) -> (Vec<WallSpec>, usize) {
        let (columns, cell_m) = (self.columns(), self.cell_m());
        let (mut walls, mut sides) = (Vec::with_capacity(self.walls + 1), 0);
        while walls.len() < self.walls {
            walls.extend(room_side(sides, columns, cell_m, dice));
            sides += 1;
        }
        walls.truncate(self.walls);
        (walls, sides.div_ceil(2 * columns).max(1))
    }

    /// One free-standing wall in each cell, row by row; and the number of rows.
    fn segments(&self, dice: &mut Dice) -> (Vec<WallSpec>, usize) {
        let (columns, cell_m) = (self.columns(), self.cell_m());
        let reach_m = 0.5 * cell_m - MARGIN_M;
        let one = |cell: usize| {
            let half_m = reach_m * (0.3 + 0.7 * dice.uniform());
            let (s, c) = trig::sin_cos(core::f64::consts::PI * dice.uniform());
            let (dx, dy) = (half_m * c, half_m * s);
            let shift = |half: f64, u: f64| (reach_m - half.abs()) * (2.0 * u - 1.0);
            let (shift_x, shift_y) = (shift(dx, dice.uniform()), shift(dy, dice.uniform()));
            let x = cell_m * ((cell % columns) as f64 + 0.5) + shift_x;
            let y = cell_m * ((cell / columns) as f64 + 0.5) + shift_y;
            wall([x - dx, y - dy], [x + dx, y + dy])
        };
        ((0..self.walls).map(one).collect(), self.walls.div_ceil(columns).max(1))
    }
}

/// Up to `count` poses in `world`'s bounds that are at least `clearance_m` from
/// every wall, in all directions; fewer where chance finds too few.
#[must_use]
pub fn free_poses(world: &World, seed: u64, count: usize, clearance_m: f64) -> Vec<SE2> {
    let mut dice = Dice::new(seed);
    let [x_min, y_min, x_max, y_max] = world.bounds();
    let drawn = (0..1000 * count).map(|_| {
        let x = x_min + (x_max - x_min) * dice.uniform();
        let y = y_min + (y_max - y_min) * dice.uniform();
        SE2::new(x, y, core::f64::consts::PI * (2.0 * dice.uniform() - 1.0))
    });
    let free =
        |pose: &SE2| world.distance_to_nearest(Point2::from(pose.translation())) >= clearance_m;
    drawn.filter(free).take(count).collect()
}

pub(crate) fn wall(a: [f64; 2], b: [f64; 2]) -> WallSpec {
    WallSpec { a, b, material: Material::Wall }
}

/// The walls of one side of a room: none in one of eight, two next to a door in
/// one of two, otherwise one. Sides 2k and 2k + 1 are the lower and the left
/// one of room k.
fn room_side(side: usize, columns: usize, cell_m: f64, dice: &mut Dice) -> Vec<WallSpec> {
    let (column, row) = (side / 2 % columns, side / 2 / columns);
    let is_level = side.is_multiple_of(2);
    let along = |from: f64, to: f64| {
        let (x, y) = (column as f64, row as f64);
        // Neighbours compute a shared corner by the same product, so it is one.
        if is_level {
            wall([cell_m * (x + from), cell_m * y], [cell_m * (x + to), cell_m * y])
        } else {
            wall([cell_m * x, cell_m * (y + from)], [cell_m * x, cell_m * (y + to)])
        }
    };
    let chance = dice.uniform();
    let door = 0.2 + 0.3 * dice.uniform();
    if chance < 0.125 {
        Vec::new()
    } else if chance < 0.625 {
        vec![along(0.0, door), along(door + 0.3, 1.0)]
    } else {
        vec![along(0.0, 1.0)]
    }
}

/// A generator of random numbers (SplitMix64, Steele, Lea and Flood 2014).
pub(crate) struct Dice(u64);

impl Dice {
    /// The numbers of a seed.
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next number, uniform in [0, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recipes() -> impl Iterator<Item = Recipe> {
        let kinds = [Pattern::Rooms, Pattern::Segments];
        let ways = [Density::Constant, Density::Area];
        let sizes = [1, 2, 3, 64, 512, 4096, 32_768];
        kinds.into_iter().flat_map(move |pattern| {
            ways.into_iter().flat_map(move |density| {
                sizes.into_iter().map(move |walls| Recipe { pattern, density, walls, seed: 5 })
            })
        })
    }

    #[test]
    fn every_recipe_makes_a_world_of_its_size_with_places_to_stand() {
        for recipe in recipes() {
            let world = World::new(recipe.spec()).unwrap_or_else(|e| panic!("{recipe:?}: {e}"));
            assert_eq!(world.walls().len(), recipe.walls, "{recipe:?}");
            let poses = free_poses(&world, 1, 16, 0.05);
            assert_eq!(poses.len(), 16, "{recipe:?}");
        }
    }

    #[test]
    fn a_seed_gives_one_world_and_another_gives_another() {
        for recipe in recipes().filter(|r| r.walls == 512) {
            assert_eq!(recipe.spec(), recipe.spec());
            assert_ne!(recipe.spec(), Recipe { seed: 6, ..recipe }.spec());
        }
    }

    #[test]
    fn the_density_or_the_area_stays() {
        let side_m = |density, walls| {
            Recipe { pattern: Pattern::Segments, density, walls, seed: 5 }.spec().bounds[2]
        };
        assert_eq!(side_m(Density::Constant, 64), 12.0);
        assert_eq!(side_m(Density::Constant, 64 * 64), 96.0);
        assert_eq!(side_m(Density::Area, 64), 64.0);
        assert_eq!(side_m(Density::Area, 64 * 64), 64.0);
    }

    #[test]
    fn pinned_bits() {
        // What a recipe makes must not drift: hashes of scans are compared
        // between machines.
        let recipe =
            Recipe { pattern: Pattern::Segments, density: Density::Area, walls: 64, seed: 1 };
        let [x, y] = recipe.spec().walls[63].a;
        assert_eq!((x.to_bits(), y.to_bits()), (0x404f_3e23_5532_60bd, 0x404c_4bff_82ba_8a13));
    }
}
