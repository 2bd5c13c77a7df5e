//! The file format of a world: a name, a box and a list of walls.
//!
//! In TOML (JSON has the same keys):
//!
//! ```toml
//! name = "box"
//! bounds = [0.0, 0.0, 4.0, 3.0]          # x_min, y_min, x_max, y_max, metres
//!
//! [[walls]]
//! a = [0.0, 0.0]                         # metres, world frame
//! b = [4.0, 0.0]
//! material = "Wall"                      # "Wall", "Glass" or "Door(3)"
//! ```
//!
//! A world may also have landmarks: points with a number, which stop neither a ray
//! nor a body, `landmarks = [{ id = 1, at = [2.0, 1.5] }]`.
//!
//! Unknown keys are errors. Reading checks the form only; [`WorldSpec::check`]
//! checks the sense, and [`World::new`](crate::World::new) calls it.

use std::collections::BTreeSet;

use nalgebra::Point2;
use serde::{Deserialize, Serialize};

use crate::exactly;
use crate::gap::{GAP_M, Gap, MAX_STEPS, find_gaps};
use crate::material::Material;
use crate::wall::Wall;
use crate::world_error::WorldError;

/// The longest name, in characters.
pub const MAX_NAME_CHARS: usize = 64;
/// The largest number of walls.
pub const MAX_WALLS: usize = 100_000;
/// The shortest wall, metres.
pub const MIN_WALL_M: f64 = 1e-6;
/// The largest coordinate of the bounds, metres: up to here the rounding of a
/// coordinate stays near 1e-10 m.
pub const MAX_COORDINATE_M: f64 = 1e6;

/// One wall of a world file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallSpec {
    /// One end, `[x, y]` in metres, world frame.
    #[serde(deserialize_with = "exactly::numbers")]
    pub a: [f64; 2],
    /// The other end, `[x, y]` in metres, world frame.
    #[serde(deserialize_with = "exactly::numbers")]
    pub b: [f64; 2],
    /// What it is made of.
    pub material: Material,
}

/// The largest number of landmarks.
pub const MAX_LANDMARKS: usize = 4096;

/// A point that a landmark sensor measures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Landmark {
    /// Its number, unique in the world.
    pub id: u32,
    /// Where it is, `[x, y]` in metres, world frame.
    #[serde(deserialize_with = "exactly::numbers")]
    pub at: [f64; 2],
}

/// A world as it is in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldSpec {
    /// A short name.
    pub name: String,
    /// `[x_min, y_min, x_max, y_max]` in metres, world frame.
    #[serde(deserialize_with = "exactly::numbers")]
    pub bounds: [f64; 4],
    /// The walls; their order breaks ties between equally near ones. Required,
    /// though it may be empty: a file that forgot its walls is no open world.
    pub walls: Vec<WallSpec>,
    /// The landmarks; a world may have none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub landmarks: Vec<Landmark>,
}

impl From<&WallSpec> for Wall {
    fn from(spec: &WallSpec) -> Self {
        Self { a: Point2::from(spec.a), b: Point2::from(spec.b), material: spec.material }
    }
}

impl WorldSpec {
    /// Reads a world from TOML text.
    ///
    /// # Errors
    /// [`WorldError::Text`] with the parser's place and reason.
    pub fn from_toml_str(text: &str) -> Result<Self, WorldError> {
        toml::from_str(text).map_err(|error| WorldError::Text {
            format: "TOML",
            detail: error.to_string().trim_end().to_owned(),
        })
    }

    /// Reads a world from JSON text.
    ///
    /// # Errors
    /// [`WorldError::Text`] with the parser's place and reason.
    pub fn from_json_str(text: &str) -> Result<Self, WorldError> {
        serde_json::from_str(text)
            .map_err(|error| WorldError::Text { format: "JSON", detail: error.to_string() })
    }

    /// The world as TOML text that reads back to the same bits.
    ///
    /// # Errors
    /// [`WorldError::Write`] with the writer's reason.
    pub fn to_toml(&self) -> Result<String, WorldError> {
        toml::to_string(self).map_err(|error| WorldError::Write {
            name: self.name.clone(),
            format: "TOML",
            detail: error.to_string(),
        })
    }

    /// The world as JSON text that reads back to the same bits, if every number
    /// is finite (JSON has no others).
    ///
    /// # Errors
    /// [`WorldError::Write`] with the writer's reason.
    pub fn to_json(&self) -> Result<String, WorldError> {
        serde_json::to_string_pretty(self).map_err(|error| WorldError::Write {
            name: self.name.clone(),
            format: "JSON",
            detail: error.to_string(),
        })
    }

    /// The walls as geometry, in file order.
    #[must_use]
    pub fn to_walls(&self) -> Vec<Wall> {
        self.walls.iter().map(Wall::from).collect()
    }

    /// Wall ends that touch no other wall but stop within 5 cm of one; see
    /// [`Gap`]. Meaningful for finite walls.
    ///
    /// # Errors
    /// [`WorldError::GapsNotChecked`] where the search takes too long.
    pub fn gaps(&self) -> Result<Vec<Gap>, WorldError> {
        self.ends_near(GAP_M, usize::MAX)
    }

    /// Wall ends that touch no other wall, and are closer than `reach_m` (metres,
    /// may be infinite) to one: the first `most` of them, in order of walls and ends.
    /// Naming each takes time proportional to the number of walls.
    ///
    /// # Errors
    /// [`WorldError::GapsNotChecked`] where the search takes too long.
    pub fn ends_near(&self, reach_m: f64, most: usize) -> Result<Vec<Gap>, WorldError> {
        Ok(self.find_gaps(&self.to_walls(), reach_m)?.take(most).collect())
    }

    /// Whether this is a world one can run in: a short name, ordered bounds,
    /// finite walls of some length inside them, and no gap.
    ///
    /// # Errors
    /// The first thing wrong, naming the wall by its index from 0.
    pub fn check(&self) -> Result<(), WorldError> {
        self.check_frame()?;
        for (index, wall) in self.walls.iter().enumerate() {
            self.check_wall(index, wall)?;
        }
        self.check_landmarks()?;
        match self.find_gaps(&self.to_walls(), GAP_M)?.next() {
            None => Ok(()),
            Some(gap) => Err(WorldError::Gap { name: self.name.clone(), gap }),
        }
    }

    fn find_gaps<'w>(
        &self,
        walls: &'w [Wall],
        reach_m: f64,
    ) -> Result<impl Iterator<Item = Gap> + use<'w>, WorldError> {
        find_gaps(walls, reach_m, MAX_STEPS).ok_or_else(|| WorldError::GapsNotChecked {
            name: self.name.clone(),
            count: self.walls.len(),
            limit: MAX_STEPS,
        })
    }

    /// The name, the bounds and the number of walls.
    fn check_frame(&self) -> Result<(), WorldError> {
        let name = self.name.clone();
        let chars = name.chars().count();
        if chars == 0 || chars > MAX_NAME_CHARS || name.chars().any(char::is_control) {
            return Err(WorldError::Name { name, limit: MAX_NAME_CHARS });
        }
        let bounds = self.bounds;
        let [x_min, y_min, x_max, y_max] = bounds;
        // NaN fails the first test, infinity too.
        let near = bounds.iter().all(|c| c.abs() <= MAX_COORDINATE_M);
        if !(near && x_min < x_max && y_min < y_max) {
            return Err(WorldError::Bounds { name, bounds, limit_m: MAX_COORDINATE_M });
        }
        let count = self.walls.len();
        if count > MAX_WALLS {
            return Err(WorldError::TooManyWalls { name, count, limit: MAX_WALLS });
        }
        Ok(())
    }

    /// The landmarks: not too many, inside the bounds, each with a unique number.
    fn check_landmarks(&self) -> Result<(), WorldError> {
        let count = self.landmarks.len();
        let problem = |landmark: usize, problem: String| {
            Err(WorldError::Landmark { name: self.name.clone(), landmark, problem })
        };
        if count > MAX_LANDMARKS {
            let text = format!("there are {count}, at most {MAX_LANDMARKS} are allowed");
            return problem(MAX_LANDMARKS, text);
        }
        let [x_min, y_min, x_max, y_max] = self.bounds;
        let mut ids = BTreeSet::new();
        for (index, Landmark { id, at: [x, y] }) in self.landmarks.iter().enumerate() {
            if !((x_min..=x_max).contains(x) && (y_min..=y_max).contains(y)) {
                let bounds = self.bounds;
                return problem(index, format!("[{x}, {y}] is not within the bounds {bounds:?}"));
            }
            if !ids.insert(id) {
                return problem(index, format!("id {id} is there twice"));
            }
        }
        Ok(())
    }

    /// One wall by itself: finite, long enough, inside the bounds.
    fn check_wall(&self, wall: usize, spec: &WallSpec) -> Result<(), WorldError> {
        let WallSpec { a, b, .. } = *spec;
        let name = || self.name.clone();
        if !a.iter().chain(&b).all(|c| c.is_finite()) {
            return Err(WorldError::NotFinite { name: name(), wall, a, b });
        }
        let bounds = self.bounds;
        let [x_min, y_min, x_max, y_max] = bounds;
        for (end, point) in [('a', a), ('b', b)] {
            let [x, y] = point;
            if !(x_min <= x && x <= x_max && y_min <= y && y <= y_max) {
                return Err(WorldError::OutOfBounds { name: name(), wall, end, point, bounds });
            }
        }
        let length_m = Wall::from(spec).length_m();
        if length_m < MIN_WALL_M {
            let limit_m = MIN_WALL_M;
            return Err(WorldError::TooShort { name: name(), wall, a, b, length_m, limit_m });
        }
        Ok(())
    }
}
