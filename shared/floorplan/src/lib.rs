//! World files: floor plans in TOML and JSON, maps of ROS, drawings in SVG.
//!
//! In reading order:
//!
//! * [`map_server`]: maps of ROS, read and written;
//! * [`trace`]: walls of such a map;
//! * [`svg`]: walls of a drawing;
//! * [`snap`]: ends that almost touch a wall, joined to it;
//! * [`openings`]: where a floor is open to the outside;
//! * [`check`]: gaps, loose ends, overlaps and openings of a floor plan.
//!
//! All of it is a function of the files alone: no clock, no platform libm.

pub mod check;
pub mod map_server;
pub mod openings;
pub mod snap;
pub mod svg;
pub mod trace;

use std::path::Path;

use rusty_contract::suggest::{did_you_mean, for_message, without_types};
use rusty_contract::{FieldError, input};
use rusty_geometry::places::{PLACES, place};
use rusty_geometry::{WallSpec, WorldError, WorldSpec};
use thiserror::Error;

use map_server::{MapFileError, RosMap};
use trace::Traced;

/// Longest world file that is read, bytes: 100 000 walls need less.
const MAX_FILE_BYTES: u64 = 32 << 20;

/// Why a world file cannot be used.
#[derive(Debug, Error)]
pub enum FloorplanError {
    /// The file cannot be read.
    #[error("{path}: {error}{hint}")]
    Read {
        /// The file.
        path: String,
        /// What the operating system reported.
        error: std::io::Error,
        /// Names that may have been meant.
        hint: String,
    },
    /// The page or the picture of a map cannot be read.
    #[error(transparent)]
    Map(#[from] MapFileError),
    /// A part of the file cannot be used.
    #[error("{path}: {error}")]
    Field {
        /// The file.
        path: String,
        /// The part, and what to write instead.
        error: FieldError,
    },
    /// The world cannot be used.
    #[error("{path}: {}{}", without_types(&error.to_string()), for_message(&error.to_string()))]
    World {
        /// The file.
        path: String,
        /// What is wrong.
        error: WorldError,
    },
}

/// A map of ROS with its walls.
#[derive(Clone, Debug)]
pub struct TracedMap {
    /// The cells.
    pub map: RosMap,
    /// The walls.
    pub traced: Traced,
}

/// Returns a checked world: a built-in one by name, or a file by path.
///
/// # Errors
/// [`FloorplanError`] names file, place, value and remedy.
pub fn world(which: &str) -> Result<WorldSpec, FloorplanError> {
    match place(which) {
        Some(place) => Ok(place.spec().clone()),
        None => read(Path::new(which)),
    }
}

/// Reads and checks a world file: `.yaml` and `.yml` as a map of ROS, `.svg`, `.json`,
/// and all others as TOML.
///
/// # Errors
/// [`FloorplanError`] names file, place, value and remedy.
pub fn read(path: &Path) -> Result<WorldSpec, FloorplanError> {
    let spec = read_unchecked(path)?;
    spec.check().map_err(at(path))?;
    Ok(spec)
}

/// Reads a world file as [`read`] does, but checks its form only.
///
/// # Errors
/// [`FloorplanError`] names file, place, value and remedy.
pub fn read_unchecked(path: &Path) -> Result<WorldSpec, FloorplanError> {
    match ending(path).as_str() {
        "yaml" | "yml" => Ok(read_map(path)?.traced.world),
        "svg" => svg::walls(&read_text(path)?, &stem(path)).map_err(field(path)),
        "json" => WorldSpec::from_json_str(&read_text(path)?).map_err(at(path)),
        _ => WorldSpec::from_toml_str(&read_text(path)?).map_err(at(path)),
    }
}

/// Reads and traces a map of ROS, if the ending is that of one.
///
/// # Errors
/// [`FloorplanError`] names file, place, value and remedy.
pub fn map_of(path: &Path) -> Result<Option<TracedMap>, FloorplanError> {
    matches!(ending(path).as_str(), "yaml" | "yml").then(|| read_map(path)).transpose()
}

fn read_map(path: &Path) -> Result<TracedMap, FloorplanError> {
    let map = RosMap::load(path)?;
    let traced = trace::trace(&map, &stem(path)).map_err(field(path))?;
    Ok(TracedMap { map, traced })
}

fn read_text(path: &Path) -> Result<String, FloorplanError> {
    input::read_text_at_most(path, MAX_FILE_BYTES).map_err(|error| {
        let (path, names) = (path.display().to_string(), PLACES.iter().map(|(name, _)| *name));
        let all: Vec<&str> = names.clone().collect();
        let hint = format!("; built-in worlds: {}{}", all.join(", "), did_you_mean(&path, names));
        FloorplanError::Read { path, error, hint }
    })
}

fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

/// Name of a world whose file has none.
fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn at(path: &Path) -> impl FnOnce(WorldError) -> FloorplanError {
    let path = path.display().to_string();
    move |error| FloorplanError::World { path, error }
}

fn field(path: &Path) -> impl FnOnce(FieldError) -> FloorplanError {
    let path = path.display().to_string();
    move |error| FloorplanError::Field { path, error }
}

/// A length to the nanometre: 23 cells of 0.05 m are 1.15 m, not 1.1500000000000001 m.
fn rounded(metres: f64) -> f64 {
    (metres * 1e9).round() / 1e9
}

/// The box around walls and 10 cm around it, metres.
fn bounds_of(walls: &[WallSpec]) -> [f64; 4] {
    let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for [x, y] in walls.iter().flat_map(|wall| [wall.a, wall.b]) {
        let [x0, y0, x1, y1] = bounds;
        bounds = [x0.min(x), y0.min(y), x1.max(x), y1.max(y)];
    }
    let [x0, y0, x1, y1] = bounds;
    [x0 - 0.1, y0 - 0.1, x1 + 0.1, y1 + 0.1].map(rounded)
}

#[cfg(test)]
mod tests;
