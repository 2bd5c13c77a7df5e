//! `Start`: what a participant is told before the first tick.

use std::sync::Mutex;

use numpy::{PyArray1, PyArray2, PyArrayMethods as _};
use pyo3::prelude::*;
use rusty_contract::Start as Told;

use crate::errors::misused;

/// What a participant is told before the first tick. What its role may not know
/// is None.
#[pyclass(frozen, module = "rusty")]
pub struct Start {
    /// The same in Rust.
    pub told: Told,
    /// What the maker says of the robot.
    #[pyo3(get)]
    robot: Py<Robot>,
    /// The LiDAR.
    #[pyo3(get)]
    lidar: Py<Lidar>,
    /// The walls, m, world frame: rows (x_a, y_a, x_b, y_b), float64 of shape
    /// (walls, 4), read-only; None where the map is hidden.
    #[pyo3(get)]
    map: Option<Py<PyArray2<f64>>>,
}

/// What the maker says of the robot.
#[pyclass(frozen, get_all, module = "rusty")]
pub struct Robot {
    /// Nominal wheel radius, m.
    wheel_radius_m: f64,
    /// Nominal distance between the wheels' contact points, m.
    track_m: f64,
    /// Encoder counts per wheel revolution.
    ticks_per_rev: u64,
    /// Radius of the body's disc, m; it is what touches walls.
    body_radius_m: f64,
    /// Fastest a wheel can turn, rad/s.
    wheel_limit_rad_s: f64,
}

/// Geometry of the LiDAR's beams, and its figures where they are told.
#[pyclass(frozen, get_all, module = "rusty")]
pub struct Lidar {
    /// Number of beams n.
    beams: u32,
    /// Bearing of each beam in the sensor frame, rad, float64 of shape (n,),
    /// read-only.
    bearings_rad: Py<PyArray1<f64>>,
    /// Bearing of beam 0 in the sensor frame, rad.
    first_bearing_rad: f64,
    /// Angle over which the n beams are spread, rad; beam k points along
    /// first_bearing_rad + fov_rad * k / n.
    fov_rad: f64,
    /// Range that a beam reports when nothing came back, m.
    range_max_m: f64,
    /// Standard deviation of a range at distance 0, m; None: not told, as with all
    /// figures below.
    range_std_m: Option<f64>,
    /// Growth of the standard deviation with the range, m per m; both add in
    /// squares.
    range_std_per_m: Option<f64>,
    /// Probability that a beam returns nothing.
    dropout: Option<f64>,
    /// Greatest angle of incidence at which every pane of glass returns every
    /// beam, rad; beyond it a beam may pass. pi/2: glass is like a wall.
    glass_visible_rad: Option<f64>,
    /// Full angle of the footprint of a beam, rad.
    divergence_rad: Option<f64>,
    /// Pose of the sensor on the body, (x m, y m, theta rad).
    sensor_in_body: (f64, f64, f64),
}

impl Start {
    fn new(py: Python<'_>, told: Told) -> PyResult<Self> {
        let (drive, nominal) = (told.robot.drive, told.robot);
        let robot = Robot {
            wheel_radius_m: drive.wheel_radius_m,
            track_m: drive.track_m,
            ticks_per_rev: drive.ticks_per_rev,
            body_radius_m: nominal.body_radius_m,
            wheel_limit_rad_s: nominal.wheel_limit_rad_s,
        };
        let said = &told.lidar;
        let bearings_rad: Vec<f64> = (0..said.beams).map(|k| said.bearing_rad(k)).collect();
        let bearings_rad = PyArray1::from_vec(py, bearings_rad);
        drop(bearings_rad.try_readwrite()?.make_nonwriteable());
        let sensor = said.sensor_in_body;
        let lidar = Lidar {
            beams: said.beams,
            bearings_rad: bearings_rad.unbind(),
            first_bearing_rad: said.first_bearing_rad,
            fov_rad: said.fov_rad,
            range_max_m: said.range_max_m,
            range_std_m: said.range_std_m,
            range_std_per_m: said.range_std_per_m,
            dropout: said.dropout,
            glass_visible_rad: said.glass_visible_rad,
            divergence_rad: said.divergence_rad,
            sensor_in_body: (sensor.x(), sensor.y(), sensor.theta()),
        };
        let map = told.map.as_ref().map(|world| {
            let ends = world.walls.iter().flat_map(|wall| [wall.a, wall.b]).flatten();
            let flat = PyArray1::from_iter(py, ends);
            let map = flat.reshape([world.walls.len(), 4])?;
            drop(map.try_readwrite()?.make_nonwriteable());
            Ok::<_, PyErr>(map.unbind())
        });
        let map = map.transpose()?;
        Ok(Self { robot: Py::new(py, robot)?, lidar: Py::new(py, lidar)?, map, told })
    }
}

#[pymethods]
impl Start {
    /// Name in the roster.
    #[getter]
    fn name(&self) -> &str {
        &self.told.name
    }

    /// Role in the roster: "estimator", "driver" or "observer".
    #[getter]
    fn role(&self) -> &'static str {
        self.told.role.word()
    }

    /// Name of the scenario.
    #[getter]
    fn scenario(&self) -> &str {
        &self.told.scenario
    }

    /// Length of a tick, s.
    #[getter]
    fn dt_s(&self) -> f64 {
        self.told.dt_s
    }

    /// How many ticks the run has.
    #[getter]
    fn ticks(&self) -> u64 {
        self.told.ticks
    }

    /// One scan every N ticks; 0: none.
    #[getter]
    fn scan_every(&self) -> u64 {
        self.told.scan_every
    }

    /// Whose figures of the sensors these are: "given" (those of the run), "nominal"
    /// (those of the data sheets) or "hidden" (None).
    #[getter]
    fn data_sheet(&self) -> &'static str {
        self.told.data_sheet.word()
    }

    /// The small sensors, as in the `[sensors]` of a scenario: what is there, where it
    /// is mounted, and its noise, where that is told.
    #[getter]
    fn sensors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = serde_json::to_string(&self.told.sensors).unwrap_or_default();
        py.import("json")?.call_method1("loads", (text,))
    }

    /// Where the robot starts in the world frame, (x m, y m, theta rad), where
    /// that is told.
    #[getter]
    fn initial_pose(&self) -> Option<(f64, f64, f64)> {
        self.told.initial_pose.map(|pose| (pose.x(), pose.y(), pose.theta()))
    }

    /// What the walls of the map are made of, in its order: "Wall", "Glass",
    /// "Door(3)".
    #[getter]
    fn materials(&self) -> Option<Vec<String>> {
        let world = self.told.map.as_ref()?;
        Some(world.walls.iter().map(|wall| wall.material.to_string()).collect())
    }

    /// The box that holds the map: (x_min, y_min, x_max, y_max), m.
    #[getter]
    fn bounds(&self) -> Option<(f64, f64, f64, f64)> {
        self.told.map.as_ref().map(|world| world.bounds.into())
    }

    fn __repr__(&self) -> String {
        let Told { name, role, scenario, ticks, dt_s, .. } = &self.told;
        format!("<rusty.Start of {name:?} ({role}) in {scenario:?}: {ticks} ticks of {dt_s} s>")
    }
}

/// The start of the session that joined last.
static LAST: Mutex<Option<Py<Start>>> = Mutex::new(None);

/// Makes a start, and keeps it as the last one.
pub fn remember(py: Python<'_>, told: Told) -> PyResult<Py<Start>> {
    let start = Py::new(py, Start::new(py, told)?)?;
    let next = Some(start.clone_ref(py));
    // What was there goes when the lock has gone: that may run any code.
    let _before = LAST.lock().map_or(None, |mut last| std::mem::replace(&mut *last, next));
    Ok(start)
}

/// The start of the session that joined last.
#[pyfunction]
fn _last_start(py: Python<'_>) -> PyResult<Py<Start>> {
    let last = LAST.lock().ok().and_then(|last| last.as_ref().map(|start| start.clone_ref(py)));
    last.ok_or_else(|| misused("nobody has joined a run yet: call rusty.join() first".to_owned()))
}

/// Adds the start to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Start>()?;
    module.add_class::<Robot>()?;
    module.add_class::<Lidar>()?;
    module.add_function(wrap_pyfunction!(_last_start, module)?)
}
