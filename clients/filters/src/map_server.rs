//! Maps of cells as files in the format of ROS: see [`rusty_floorplan::map_server`].
//!
//! Departure: a map that is turned (yaw is not 0) is refused. A grid here is aligned
//! with the world frame, and a map that is silently not would be wrong everywhere.

use std::path::Path;

use nalgebra::Point2;
use rusty_clients::ClientError;
use rusty_contract::FieldError;
use rusty_floorplan::map_server::{MapFileError, RosMap};

use crate::{GridFrame, OccupancyMap};

fn client_error(error: MapFileError) -> ClientError {
    match error {
        MapFileError::Io { path, error } => ClientError::Io { path, error },
        other => ClientError::Unusable(other.to_string()),
    }
}

impl OccupancyMap {
    /// Reads a map in the format of ROS, by the path of its YAML page.
    ///
    /// # Errors
    /// [`ClientError`] names file, field, value and remedy.
    pub fn load(yaml: &Path) -> Result<Self, ClientError> {
        let map = RosMap::load(yaml).map_err(client_error)?;
        if map.yaw_rad != 0.0 {
            let (problem, remedy) = ("turns the map", "turn the picture, and give a yaw of 0");
            let error = FieldError::new("origin[2]", map.yaw_rad, problem, remedy);
            let path = yaml.display().to_string();
            return Err(client_error(MapFileError::Field { path, error }));
        }
        let frame = GridFrame {
            origin_m: Point2::from(map.origin_m),
            cell_m: map.cell_m,
            width: map.width,
            height: map.cells.len() / map.width,
        };
        Ok(Self { frame, cells: map.cells })
    }

    /// Writes the map as `stem.pgm` and `stem.yaml`, and makes the folder where
    /// there is none. [`load`](Self::load) gives this very map again.
    ///
    /// # Errors
    /// [`ClientError`] names the file that cannot be written.
    pub fn save(&self, stem: &Path) -> Result<(), ClientError> {
        let GridFrame { origin_m, cell_m, width, .. } = self.frame;
        let (origin_m, cells) = ([origin_m.x, origin_m.y], self.cells.clone());
        let map = RosMap { origin_m, yaw_rad: 0.0, cell_m, width, cells };
        map.save(stem).map_err(client_error)
    }
}

#[cfg(test)]
mod tests;
