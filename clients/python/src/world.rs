//! `rusty.World`: walls, rays and scans, for the models of a filter.
//!
//! The geometry's own functions, bit for bit. No noise, and no way to the
//! simulator: a model is a belief about the world, never the world.

use std::path::PathBuf;

use nalgebra::Point2;
use numpy::ndarray::Dim;
use numpy::{PyArray, PyArray1, PyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rusty_geometry::{Material, PLACES, SE2, WallSpec, World, WorldSpec, place};

use crate::arrays::{floats, rows, shaped};
use crate::beams::Beams;
use crate::se2::pose_of;
use crate::start::Start;

/// Longest world file that is read, bytes: 100 000 walls need less.
const MAX_FILE_BYTES: u64 = 32 << 20;

/// A checked, immutable world: straight walls in the plane, in a search tree.
///
/// Made by `World.builtin`, `World.from_file`, `World.from_walls` or
/// `World.from_json`. Lengths are metres, angles radians, in the world frame.
#[pyclass(frozen, name = "World", module = "rusty")]
pub struct PyWorld(pub World);

#[pymethods]
impl PyWorld {
    /// A built-in world: "open", "hallway", "apartment", "lobby", "corridor", "twin-rooms",
    /// "workshop" or "warehouse".
    #[staticmethod]
    fn builtin(name: &str) -> PyResult<Self> {
        let names = || PLACES.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
        let none = || PyValueError::new_err(format!("no built-in world {name:?}; use {}", names()));
        place(name).map(Self).ok_or_else(none)
    }

    /// The world in a file, TOML or (ending in .json) JSON. Maps of ROS and drawings
    /// are converted by `sim-server worlds FILE --json`: the package has no parser of
    /// YAML, PNG and SVG.
    #[staticmethod]
    fn from_file(path: PathBuf) -> PyResult<Self> {
        let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
        if ["yaml", "yml", "svg"].iter().any(|other| ending == *other) {
            let file = path.display();
            let problem = format!(
                "{file}: expected TOML or JSON; convert it by `sim-server worlds {file} --json > \
                 world.json`"
            );
            return Err(PyValueError::new_err(problem));
        }
        let text = read_text(&path)?;
        let is_json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
        let spec =
            if is_json { WorldSpec::from_json_str(&text) } else { WorldSpec::from_toml_str(&text) };
        spec.and_then(World::new)
            .map(Self)
            .map_err(|e| PyValueError::new_err(format!("{}: {e}", path.display())))
    }

    /// The world in JSON text: `name`, `bounds` [x_min, y_min, x_max, y_max] and
    /// `walls`, each with `a` [x, y], `b` [x, y] and `material`.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        Self::new(WorldSpec::from_json_str(text).map_err(refused)?)
    }

    /// The map that a participant was given.
    #[staticmethod]
    fn from_start(start: &Bound<'_, Start>) -> PyResult<Self> {
        let map = start.get().told.map.clone();
        let hidden = "the map is hidden from this participant: the scenario's map = \"hidden\"";
        Self::new(map.ok_or_else(|| PyValueError::new_err(hidden))?)
    }

    /// A world of walls (N, 4): x and y of one end, x and y of the other, m.
    ///
    /// `bounds` are (x_min, y_min, x_max, y_max), m; left out, they are those of
    /// the walls. `materials` are N texts, "Wall", "Glass" or "Door(3)"; left
    /// out, all are "Wall".
    #[staticmethod]
    #[pyo3(signature = (walls, *, bounds = None, materials = None, name = "walls"))]
    fn from_walls(
        walls: &Bound<'_, PyAny>,
        bounds: Option<[f64; 4]>,
        materials: Option<Vec<String>>,
        name: &str,
    ) -> PyResult<Self> {
        let ends = rows::<4>(walls, "walls")?;
        let materials = match materials {
            None => vec![Material::Wall; ends.len()],
            Some(words) if words.len() == ends.len() => words
                .iter()
                .map(|word| word.parse().map_err(|e| PyValueError::new_err(format!("{e}"))))
                .collect::<PyResult<_>>()?,
            Some(words) => {
                let (n, walls) = (words.len(), ends.len());
                let problem = format!("materials: {n} of them, and {walls} walls; give one each");
                return Err(PyValueError::new_err(problem));
            }
        };
        let wall = |(end, material): (&[f64; 4], Material)| WallSpec {
            a: [end[0], end[1]],
            b: [end[2], end[3]],
            material,
        };
        Self::new(WorldSpec {
            name: name.to_owned(),
            bounds: bounds.unwrap_or_else(|| bounds_of(&ends)),
            walls: ends.iter().zip(materials).map(wall).collect(),
            landmarks: Vec::new(),
        })
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    /// The walls, float64 (N, 4): x and y of one end, x and y of the other, m.
    #[getter]
    fn walls<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let ends = |wall: &WallSpec| [wall.a[0], wall.a[1], wall.b[0], wall.b[1]];
        let walls = &self.0.spec().walls;
        shaped(py, walls.iter().flat_map(ends).collect(), [walls.len(), 4])
    }

    /// What each wall is made of: N texts, "Wall", "Glass" or "Door(3)".
    #[getter]
    fn materials(&self) -> Vec<String> {
        self.0.walls().iter().map(|wall| wall.material.to_string()).collect()
    }

    /// (x_min, y_min, x_max, y_max), m. They stop neither a ray nor a body.
    #[getter]
    fn bounds(&self) -> (f64, f64, f64, f64) {
        self.0.bounds().into()
    }

    /// How far a ray from `origin` (x, y) goes at `angle_rad` from the world x
    /// axis before it meets a wall; `range_max_m` where it meets none before.
    ///
    /// A single angle gives a float, an array of them an array of the same shape. Numbers
    /// that are not finite, but for an infinite `range_max_m`, are a `ValueError`, as for
    /// `scan` and `scans`.
    #[pyo3(signature = (origin, angle_rad, range_max_m = f64::INFINITY))]
    fn raycast<'py>(
        &self,
        py: Python<'py>,
        origin: [f64; 2],
        angle_rad: &Bound<'py, PyAny>,
        range_max_m: f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        check_finite(&origin, "origin")?;
        if range_max_m.is_nan() || range_max_m < 0.0 {
            let problem = format!("range_max_m={range_max_m}: expected 0 or more");
            return Err(PyValueError::new_err(problem));
        }
        let origin = Point2::from(origin);
        let cast = |angle_rad| self.0.raycast(origin, angle_rad, range_max_m).distance_m;
        if let Ok(angle_rad) = angle_rad.extract::<f64>() {
            check_finite(&[angle_rad], "angle_rad")?;
            return Ok(cast(angle_rad).into_pyobject(py)?.into_any());
        }
        let angles = floats(angle_rad, "angle_rad", "()")?;
        check_finite(&angles.numbers, "angle_rad")?;
        let distances_m = py.detach(|| angles.numbers.into_iter().map(cast).collect::<Vec<_>>());
        let array = PyArray1::from_vec(py, distances_m);
        Ok(numpy::PyArrayMethods::reshape(&array, angles.shape)?.into_any())
    }

    /// What the LiDAR of a robot at `pose` would see without noise: float64 (B,)
    /// ranges, m; `range_max_m` of the LiDAR where it meets nothing.
    ///
    /// `pose` is the body's, an `SE2` or (x m, y m, theta rad) in the world
    /// frame; `lidar` is `start.lidar`, or a dictionary like the `[lidar]` of a
    /// scenario. With `every` = k only beams 0, k, 2k, … are cast, for
    /// `ranges[::k]`.
    #[pyo3(signature = (pose, lidar, *, every = 1))]
    fn scan<'py>(
        &self,
        py: Python<'py>,
        pose: &Bound<'py, PyAny>,
        lidar: &Bound<'py, PyAny>,
        every: usize,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let body_in_world = pose_of(pose, "pose")?;
        check_finite(&[body_in_world.x(), body_in_world.y(), body_in_world.theta()], "pose")?;
        let beams = Beams::new(lidar, every)?;
        Ok(PyArray1::from_vec(py, beams.scans(&self.0, &[body_in_world])))
    }

    /// `scan` from many poses at once: float64 (P, B) ranges, m, for poses (P, 3)
    /// of (x m, y m, theta rad). Other threads of Python run meanwhile.
    #[pyo3(signature = (poses, lidar, *, every = 1))]
    fn scans<'py>(
        &self,
        py: Python<'py>,
        poses: &Bound<'py, PyAny>,
        lidar: &Bound<'py, PyAny>,
        every: usize,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let poses = rows::<3>(poses, "poses")?;
        check_finite(poses.as_flattened(), "poses")?;
        let beams = Beams::new(lidar, every)?;
        let ranges_m = py.detach(|| {
            let poses: Vec<SE2> =
                poses.iter().map(|[x, y, theta]| SE2::new(*x, *y, *theta)).collect();
            beams.scans(&self.0, &poses)
        });
        shaped(py, ranges_m, [poses.len(), beams.count()])
    }

    /// Distance from each of `points` (P, 2) to the nearest wall, float64 (P,), m:
    /// infinite in an open world, NaN for a point that is not finite. A body of
    /// radius r has room where it is at least r.
    fn distance<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray<f64, Dim<[usize; 1]>>>> {
        let points = rows::<2>(points, "points")?;
        let nearest = |point: [f64; 2]| self.0.distance_to_nearest(Point2::from(point));
        let distances_m = py.detach(|| points.into_iter().map(nearest).collect());
        Ok(PyArray1::from_vec(py, distances_m))
    }

    fn __repr__(&self) -> String {
        let [x_min, y_min, x_max, y_max] = self.0.bounds();
        let (name, walls) = (self.0.name(), self.0.walls().len());
        format!("<World {name:?}: {walls} walls in [{x_min}, {x_max}] × [{y_min}, {y_max}] m>")
    }
}

impl PyWorld {
    /// Checks the world and builds its tree.
    ///
    /// # Errors
    /// `ValueError` with wall and remedy.
    pub fn new(spec: WorldSpec) -> PyResult<Self> {
        World::new(spec).map(Self).map_err(refused)
    }
}

fn refused(error: rusty_geometry::WorldError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A ray from nowhere would meet nothing, as one into the open does.
fn check_finite(numbers: &[f64], what: &str) -> PyResult<()> {
    match numbers.iter().find(|number| !number.is_finite()) {
        None => Ok(()),
        Some(number) => {
            let problem = format!("{what}: {number} is in it; expected finite numbers");
            Err(PyValueError::new_err(problem))
        }
    }
}

fn read_text(path: &std::path::Path) -> PyResult<String> {
    use std::io::Read as _;
    let mut text = String::new();
    let read = rusty_contract::input::open(path)
        .and_then(|file| file.take(MAX_FILE_BYTES + 1).read_to_string(&mut text));
    let named =
        |e: std::io::Error| std::io::Error::new(e.kind(), format!("{}: {e}", path.display()));
    read.map_err(named)?;
    if text.len() as u64 > MAX_FILE_BYTES {
        let problem = format!(
            "{}: longer than {MAX_FILE_BYTES} bytes; is this the right file?",
            path.display()
        );
        return Err(PyValueError::new_err(problem));
    }
    Ok(text)
}

/// The box around walls, m; half a metre on both sides where it has no width.
fn bounds_of(ends: &[[f64; 4]]) -> [f64; 4] {
    let axis = |from: usize| {
        let all = ends.iter().flat_map(|end| [end[from], end[from + 2]]);
        let (low, high) = all
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| (low.min(c), high.max(c)));
        match (low < high, low.is_finite()) {
            (true, _) => (low, high),
            (false, true) => (low - 0.5, high + 0.5),
            (false, false) => (-0.5, 0.5),
        }
    };
    let ((x_min, x_max), (y_min, y_max)) = (axis(0), axis(1));
    [x_min, y_min, x_max, y_max]
}

/// Adds the world to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyWorld>()
}
