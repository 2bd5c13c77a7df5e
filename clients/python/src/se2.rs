//! `rusty.SE2`, angles and odometry: the geometry's own, bit for bit.

use nalgebra::Vector3;
use numpy::PyArray1;
use pyo3::exceptions::{PyAttributeError, PyIndexError};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use rusty_geometry::{DiffDrive, EncoderCounts, SE2};

use crate::arrays::triple;

/// A pose or a motion of the plane.
///
/// `SE2(x, y, theta)`: metres, metres, radians; the angle is wrapped to (−π, π].
/// Read as a pose it is the place of a body's frame in the world frame. Its
/// tangent vectors are arrays (ρ_x m, ρ_y m, θ rad) in the body frame.
///
/// It is immutable, unpacks like a tuple (`x, y, theta = pose`), and computes
/// with the arithmetic of the Rust crate `rusty-geometry`, bit for bit.
///
/// Source: J. Solà, J. Deray, D. Atchuthan, *A micro Lie theory for state
/// estimation in robotics* (arXiv:1812.01537).
#[pyclass(frozen, sequence, name = "SE2", module = "rusty")]
#[derive(Clone, Copy)]
pub struct PySe2(pub SE2);

/// A tangent vector as an array of shape (3,).
fn tangent<'py>(py: Python<'py>, tau: &Vector3<f64>) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_slice(py, tau.as_slice())
}

#[pymethods]
impl PySe2 {
    #[new]
    #[pyo3(signature = (x = 0.0, y = 0.0, theta = 0.0))]
    fn new(x: f64, y: f64, theta: f64) -> Self {
        Self(SE2::new(x, y, theta))
    }

    /// The motion that the constant twist `tau` (m, m, rad) makes in one unit of
    /// time; the inverse of `log`.
    #[staticmethod]
    fn exp(tau: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self(SE2::exp(&Vector3::from(triple(tau, "tau")?))))
    }

    /// World x of the origin, m.
    #[getter]
    fn x(&self) -> f64 {
        self.0.x()
    }

    /// World y of the origin, m.
    #[getter]
    fn y(&self) -> f64 {
        self.0.y()
    }

    /// Heading, rad in (−π, π], counter-clockwise from the world x axis.
    #[getter]
    fn theta(&self) -> f64 {
        self.0.theta()
    }

    /// The shortest constant twist (3,) (m, m, rad) whose `exp` this is.
    fn log<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        tangent(py, &self.0.log())
    }

    /// `self ⊞ tau`: moved by the twist `tau` (m, m, rad), given in the body frame.
    fn boxplus(&self, tau: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self(self.0.boxplus(&Vector3::from(triple(tau, "tau")?))))
    }

    /// `self ⊟ other`: the twist (3,) (m, m, rad), in the frame of `other`, with
    /// `other ⊞ twist = self`.
    fn boxminus<'py>(
        &self,
        py: Python<'py>,
        other: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(tangent(py, &self.0.boxminus(&pose_of(other, "other")?)))
    }

    /// `self ∘ other`: with `self` the pose of a frame B in A and `other` the pose
    /// of C in B, the pose of C in A. Written `self * other` or `self @ other`.
    fn compose(&self, other: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self(self.0.compose(&pose_of(other, "other")?)))
    }

    /// The motion that undoes this one.
    fn inverse(&self) -> Self {
        Self(self.0.inverse())
    }

    fn __mul__(&self, other: PyRef<'_, Self>) -> Self {
        Self(self.0.compose(&other.0))
    }

    fn __matmul__(&self, other: PyRef<'_, Self>) -> Self {
        Self(self.0.compose(&other.0))
    }

    /// Equal numbers; two NaN are not equal.
    fn __eq__(&self, other: PyRef<'_, Self>) -> bool {
        self.0 == other.0
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        self.numbers(py)?.hash()
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, pyo3::types::PyIterator>> {
        self.numbers(py)?.try_iter()
    }

    fn __len__(&self) -> usize {
        3
    }

    fn __getitem__(&self, index: isize) -> PyResult<f64> {
        match index {
            0 | -3 => Ok(self.0.x()),
            1 | -2 => Ok(self.0.y()),
            2 | -1 => Ok(self.0.theta()),
            _ => Err(PyIndexError::new_err("a pose has three numbers: x, y, theta")),
        }
    }

    fn __repr__(&self) -> String {
        format!("SE2({:?}, {:?}, {:?})", self.0.x(), self.0.y(), self.0.theta())
    }

    /// For copying and pickling.
    fn __getnewargs__(&self) -> (f64, f64, f64) {
        (self.0.x(), self.0.y(), self.0.theta())
    }
}

impl PySe2 {
    fn numbers<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        (self.0.x(), self.0.y(), self.0.theta()).into_pyobject(py)
    }
}

/// The angle in (−π, π] that differs from `theta_rad` by whole turns.
///
/// An angle already there keeps its bits; NaN and infinities give NaN.
#[pyfunction]
fn wrap_angle(theta_rad: f64) -> f64 {
    rusty_geometry::wrap_angle(theta_rad)
}

/// The tangent vector (3,) (Δs m, 0, Δθ rad) between two readings of the
/// encoders, for `pose.boxplus(delta)`.
///
/// `last_counts` and `counts` are (left, right), as `tick.encoders` has them;
/// `drive` is `start.robot`, or anything with `wheel_radius_m`, `track_m` and
/// `ticks_per_rev`. The counts are subtracted as integers: no digit is lost
/// however long the run.
#[pyfunction]
fn odometry_delta<'py>(
    py: Python<'py>,
    last_counts: (i64, i64),
    counts: (i64, i64),
    drive: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let reading = |(left, right)| EncoderCounts { left, right };
    let drive = drive_of(drive)?;
    let delta = rusty_geometry::odometry_delta(reading(last_counts), reading(counts), &drive);
    Ok(tangent(py, &delta))
}

/// The drive that an object describes by its attributes.
fn drive_of(drive: &Bound<'_, PyAny>) -> PyResult<DiffDrive> {
    let py = drive.py();
    let read = |name| {
        drive.getattr(name).map_err(|e| {
            let problem = format!("drive: {e}; give `start.robot`");
            PyAttributeError::new_err(problem)
        })
    };
    Ok(DiffDrive {
        wheel_radius_m: read(intern!(py, "wheel_radius_m"))?.extract()?,
        track_m: read(intern!(py, "track_m"))?.extract()?,
        ticks_per_rev: read(intern!(py, "ticks_per_rev"))?.extract()?,
    })
}

/// Adds the plane to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PySe2>()?;
    module.add_function(wrap_pyfunction!(wrap_angle, module)?)?;
    module.add_function(wrap_pyfunction!(odometry_delta, module)?)
}

/// A pose: an `SE2`, or (x m, y m, theta rad).
///
/// # Errors
/// `TypeError` or `ValueError`, naming `what`.
pub fn pose_of(value: &Bound<'_, PyAny>, what: &str) -> PyResult<SE2> {
    if let Ok(pose) = value.cast::<PySe2>() {
        return Ok(pose.get().0);
    }
    triple(value, what).map(|[x, y, theta]| SE2::new(x, y, theta))
}
