//! Maps of ROS: a picture of cells, and a page about it.
//!
//! Source: the `map_server` package of ROS (wiki.ros.org/map_server). The page is
//! YAML: `image`, `resolution` (m a pixel), `origin` (x and y of the lower left
//! corner, m, and a yaw, rad), `negate`, `occupied_thresh`, `free_thresh`, `mode`.
//! A pixel of brightness v (0 black to 1 white) is occupied with the probability
//! p = 1 − v, or v where `negate` is set; the cell is occupied if p is above
//! `occupied_thresh`, free if it is below `free_thresh`, and unknown otherwise.
//!
//! Departures, and why:
//! * Pictures are PGM or PNG. A coloured pixel counts by the mean of its three
//!   colours; opacity is ignored.
//! * The mode `scale` keeps what lies between the thresholds as a probability;
//!   here that is unknown, as in `trinary`. The mode `raw` has no thresholds and
//!   is refused.
//! * `free_thresh` is written as 0.196, below the 0.19608 of the grey that means
//!   unknown (205 of 255). With the 0.25 that some write, unknown cells would be
//!   free.

pub mod pgm;
pub mod png;

use std::path::{Path, PathBuf};

use rusty_contract::config::check_within;
use rusty_contract::output::make_folder;
use rusty_contract::{FieldError, input, replace};
use serde::{Deserialize, Deserializer};
use thiserror::Error;

/// Longest page that is read, bytes.
const MAX_PAGE_BYTES: u64 = 64 << 10;
/// Longest picture that is read, bytes: text takes up to six a pixel.
const MAX_PICTURE_BYTES: u64 = 6 * pgm::MAX_PIXELS as u64 + 4096;

/// What is written for a cell: free, occupied, unknown.
const GREY: [u8; 3] = [254, 0, 205];
/// More probable to be occupied than this is occupied.
pub const OCCUPIED_ABOVE: f64 = 0.65;
/// Less probable to be occupied than this is free.
pub const FREE_BELOW: f64 = 0.196;

/// Why a map cannot be read or written.
#[derive(Debug, Error)]
pub enum MapFileError {
    /// The operating system says no.
    #[error("{path}: {error}")]
    Io {
        /// The file.
        path: String,
        /// What it said.
        error: std::io::Error,
    },
    /// The page is none.
    #[error(
        "{path}: {problem}; a map's page is YAML with image, resolution, origin, negate, \
         occupied_thresh and free_thresh"
    )]
    Page {
        /// The file.
        path: String,
        /// The parser's words, with line and field.
        problem: String,
    },
    /// A field of page or picture cannot be used.
    #[error("{path}: {error}")]
    Field {
        /// The file.
        path: String,
        /// Which, and what to write instead.
        error: FieldError,
    },
}

/// State of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// Nothing is there.
    Free,
    /// Something is there.
    Occupied,
    /// Not known.
    Unknown,
}

/// A map of square cells.
#[derive(Clone, Debug, PartialEq)]
pub struct RosMap {
    /// Lower left corner of the picture, world frame, m.
    pub origin_m: [f64; 2],
    /// Angle from the x axis of the world to the rows of cells, rad.
    pub yaw_rad: f64,
    /// Side of a cell, m.
    pub cell_m: f64,
    /// Cells in a row.
    pub width: usize,
    /// The cells, row by row from the lower left.
    pub cells: Vec<Cell>,
}

fn io(path: &Path) -> impl FnOnce(std::io::Error) -> MapFileError {
    let path = path.display().to_string();
    move |error| MapFileError::Io { path, error }
}

fn field(path: &Path) -> impl FnOnce(FieldError) -> MapFileError {
    let path = path.display().to_string();
    move |error| MapFileError::Field { path, error }
}

/// The page about a picture.
#[derive(Deserialize)]
struct Page {
    image: String,
    resolution: f64,
    origin: Vec<f64>,
    #[serde(deserialize_with = "flag")]
    negate: bool,
    occupied_thresh: f64,
    free_thresh: f64,
    #[serde(default = "trinary")]
    mode: String,
}

fn trinary() -> String {
    "trinary".to_owned()
}

/// 0 or 1, as most write it, or false or true.
fn flag<'de, D: Deserializer<'de>>(deserializer: D) -> Result<bool, D::Error> {
    let text = String::deserialize(deserializer)?;
    match text.to_ascii_lowercase().as_str() {
        "0" | "false" | "no" => Ok(false),
        "1" | "true" | "yes" => Ok(true),
        _ => Err(serde::de::Error::custom(format!("negate = {text}: is neither 0 nor 1"))),
    }
}

impl Page {
    fn read(path: &Path) -> Result<Self, MapFileError> {
        let text = input::read_text_at_most(path, MAX_PAGE_BYTES).map_err(io(path))?;
        let page: Self = serde_saphyr::from_str(&text).map_err(|e| {
            let problem = e.to_string().trim().to_owned();
            MapFileError::Page { path: path.display().to_string(), problem }
        })?;
        page.check().map_err(field(path))?;
        Ok(page)
    }

    fn check(&self) -> Result<(), FieldError> {
        check_within("resolution", self.resolution, 1e-4, 1e3)?;
        if self.origin.len() != 3 {
            let (found, remedy) =
                (format!("{:?}", self.origin), "give x and y in m, and a yaw in rad");
            return Err(FieldError::new("origin", found, "has not three numbers", remedy));
        }
        check_within("origin[0]", self.origin[0], -1e6, 1e6)?;
        check_within("origin[1]", self.origin[1], -1e6, 1e6)?;
        check_within("origin[2]", self.origin[2], -7.0, 7.0)?;
        check_within("occupied_thresh", self.occupied_thresh, 0.0, 1.0)?;
        check_within("free_thresh", self.free_thresh, 0.0, 1.0)?;
        if self.free_thresh > self.occupied_thresh {
            let problem = format!("is above occupied_thresh, {}", self.occupied_thresh);
            let remedy = "cells between the two would be both free and occupied: lower it";
            return Err(FieldError::new("free_thresh", self.free_thresh, problem, remedy));
        }
        if !matches!(self.mode.as_str(), "trinary" | "scale") {
            let problem = "is not read here";
            let remedy = "save the map in the mode \"trinary\" or \"scale\"";
            return Err(FieldError::new("mode", &self.mode, problem, remedy));
        }
        Ok(())
    }

    /// Says of a picture that is not there where its name stands.
    fn without(&self, page: &Path, error: MapFileError) -> MapFileError {
        let MapFileError::Io { path, error } = error else {
            return error;
        };
        let problem = format!("{path} cannot be read ({error})");
        let remedy = "put the picture there; a name is relative to the page's folder";
        field(page)(FieldError::new("image", &self.image, problem, remedy))
    }

    /// What brightness `grey` of `white` says of a cell.
    fn cell(&self, grey: u16, white: u16) -> Cell {
        // In this order, and not as 1 − v: a pixel on a threshold must fall where
        // the one that wrote it meant it to.
        let dark = if self.negate { grey } else { white - grey };
        match f64::from(dark) / f64::from(white) {
            p if p > self.occupied_thresh => Cell::Occupied,
            p if p < self.free_thresh => Cell::Free,
            _ => Cell::Unknown,
        }
    }
}

/// `stem` with `ending` added; dots in a stem belong to it.
#[must_use]
pub fn beside(stem: &Path, ending: &str) -> PathBuf {
    let mut path = stem.as_os_str().to_owned();
    path.push(ending);
    path.into()
}

/// A number that is a number in every YAML, and reads as itself.
fn decimal(value: f64) -> String {
    let text = value.to_string();
    if text.contains('.') { text } else { format!("{text}.0") }
}

impl RosMap {
    /// Reads a map in the format of ROS, by the path of its YAML page.
    ///
    /// # Errors
    /// [`MapFileError`] names file, field, value and remedy.
    pub fn load(yaml: &Path) -> Result<Self, MapFileError> {
        let page = Page::read(yaml)?;
        let image = yaml.with_file_name("").join(&page.image);
        let bytes = input::read_at_most(&image, MAX_PICTURE_BYTES)
            .map_err(|e| page.without(yaml, io(&image)(e)))?;
        let is_png = bytes.starts_with(png::SIGNATURE);
        let picture = if is_png { png::read(&bytes) } else { pgm::read(&bytes) };
        let picture = picture.map_err(field(&image))?;
        let rows = picture.grey.chunks_exact(picture.width).rev();
        let cells = rows.flatten().map(|grey| page.cell(*grey, picture.maxval)).collect();
        Ok(Self {
            origin_m: [page.origin[0], page.origin[1]],
            yaw_rad: page.origin[2],
            cell_m: page.resolution,
            width: picture.width,
            cells,
        })
    }

    /// Writes the map as `stem.pgm` and `stem.yaml`, and makes the folder where
    /// there is none. [`load`](Self::load) gives this very map again.
    ///
    /// # Errors
    /// [`MapFileError`] names the file that cannot be written.
    pub fn save(&self, stem: &Path) -> Result<(), MapFileError> {
        let (image, yaml) = (beside(stem, ".pgm"), beside(stem, ".yaml"));
        let name = image.file_name().and_then(|name| name.to_str()).filter(|n| *n != ".pgm");
        let Some(name) = name else {
            let problem = "cannot be named in a page";
            let remedy = "give a folder and a name in Unicode without an ending";
            let error = FieldError::new("stem", stem.display(), problem, remedy);
            return Err(field(stem)(error));
        };
        if let Some(folder) = stem.parent().filter(|f| !f.as_os_str().is_empty()) {
            make_folder(folder).map_err(io(folder))?;
        }
        let Self { origin_m: [x, y], yaw_rad, cell_m, width, .. } = *self;
        let rows = self.cells.chunks_exact(width).rev();
        let height = rows.len();
        let grey: Vec<u8> = rows.flatten().map(|cell| GREY[*cell as usize]).collect();
        let comment = format!("{cell_m} m a pixel");
        replace(&image, &pgm::write(width, height, &comment, &grey)).map_err(io(&image))?;
        // A string of JSON is one of YAML.
        let name = serde_json::Value::from(name);
        let [x, y, yaw, cell] = [x, y, yaw_rad, cell_m].map(decimal);
        let page = format!(
            "image: {name}\nresolution: {cell}\norigin: [{x}, {y}, {yaw}]\nnegate: 0\n\
             occupied_thresh: {OCCUPIED_ABOVE}\nfree_thresh: {FREE_BELOW}\nmode: trinary\n"
        );
        replace(&yaml, page.as_bytes()).map_err(io(&yaml))
    }
}
