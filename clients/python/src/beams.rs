//! The beams of a LiDAR, as a model casts them.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rusty_contract::LidarConfig;
use rusty_geometry::{Fan, SE2, Scan, World};

use crate::se2::pose_of;

/// The beams of a LiDAR that are to be cast.
pub struct Beams {
    lidar: LidarConfig,
    fan: Fan,
    /// Of the fan's beams, one in N is kept.
    stride: usize,
}

impl Beams {
    /// `lidar` is a start's or a dictionary; of its beams one in `every` is cast.
    ///
    /// # Errors
    /// `TypeError` or `ValueError`, naming the field and the remedy.
    pub fn new(lidar: &Bound<'_, PyAny>, every: usize) -> PyResult<Self> {
        let lidar = lidar_of(lidar)?;
        if every == 0 {
            return Err(PyValueError::new_err(
                "every = 0: give 1 for all beams, 2 for half of them",
            ));
        }
        let beams = lidar.beams as usize;
        let fan = lidar.fan();
        // A part of an even fan is one itself where the numbers go into each other.
        if beams.is_multiple_of(every) {
            let fan = Fan { beams: (beams / every) as u32, ..fan };
            return Ok(Self { lidar, fan, stride: 1 });
        }
        Ok(Self { lidar, fan, stride: every })
    }

    /// How many beams are cast from one pose.
    pub fn count(&self) -> usize {
        (self.fan.beams as usize).div_ceil(self.stride)
    }

    /// What they see from each pose of the body, m, one pose after the other.
    pub fn scans(&self, world: &World, bodies_in_world: &[SE2]) -> Vec<f64> {
        let max_m = self.lidar.range_max_m;
        let mut scan = Scan::new(self.fan);
        let mut whole_m = vec![0.0; self.fan.beams as usize];
        let mut all_m = Vec::with_capacity(bodies_in_world.len() * self.count());
        for body_in_world in bodies_in_world {
            scan.take(world, &body_in_world.compose(&self.lidar.sensor_in_body), max_m);
            scan.write_distances_m(&mut whole_m);
            all_m.extend(whole_m.iter().step_by(self.stride));
        }
        all_m
    }
}

/// The geometry of a LiDAR that a start or a dictionary describes.
fn lidar_of(lidar: &Bound<'_, PyAny>) -> PyResult<LidarConfig> {
    let py = lidar.py();
    let named = |e: &dyn std::fmt::Display| PyValueError::new_err(format!("lidar: {e}"));
    let told = if lidar.is_instance_of::<PyDict>() {
        let json = py.import("json")?.call_method1("dumps", (lidar,))?;
        serde_json::from_str(&json.extract::<String>()?).map_err(|e| named(&e))?
    } else {
        let read = |name| {
            let wanted = "give `start.lidar`, or a dictionary like the [lidar] of a scenario";
            let problem = |e| PyTypeError::new_err(format!("lidar: {e}; {wanted}"));
            lidar.getattr(name).map_err(problem)
        };
        LidarConfig {
            beams: read(intern!(py, "beams"))?.extract()?,
            first_bearing_rad: read(intern!(py, "first_bearing_rad"))?.extract()?,
            fov_rad: read(intern!(py, "fov_rad"))?.extract()?,
            range_max_m: read(intern!(py, "range_max_m"))?.extract()?,
            sensor_in_body: pose_of(&read(intern!(py, "sensor_in_body"))?, "lidar.sensor_in_body")?,
            ..LidarConfig::default()
        }
    };
    told.check().map_err(|e| named(&e))?;
    Ok(told)
}
