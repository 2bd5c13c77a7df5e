//! `Tick`: one tick of the world, and the duty to answer it.

use std::sync::{Arc, Weak};

use numpy::ndarray::ArrayView1;
use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayLike2, PyArrayMethods as _};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use rusty_contract::score::seconds;
use rusty_contract::{BeliefKind, Estimate, Frame, Innovation, OwnedReadings, Reply, WeightedPose};
use rusty_geometry::{EncoderCounts, SE2, Twist};
use rusty_link::MAX_HELD_FRAMES;

use crate::errors::{exception, misused};
use crate::gate::{Gate, Loan, View};

/// The most arrays over frames; the session needs one more for the tick
/// that it waits for.
const MAX_VIEWS: usize = MAX_HELD_FRAMES - 1;

/// One tick of the world, read where it lies. `answer` it; left without an
/// answer it abstains when the loop goes on.
#[pyclass(frozen, module = "rusty")]
pub struct Tick {
    /// Number of the tick, from 0.
    #[pyo3(get)]
    index: u64,
    /// Time at the end of the tick, s.
    #[pyo3(get)]
    time_s: f64,
    encoders: EncoderCounts,
    command: Twist,
    has_scan: bool,
    readings: OwnedReadings,
    gate: Arc<Gate>,
    loan: Weak<Loan>,
    /// The array that was handed out.
    ranges: PyOnceLock<Py<PyArray1<f64>>>,
}

/// What an array over a frame keeps alive.
#[pyclass(frozen, name = "Frame", module = "rusty._rusty")]
pub struct Lease {
    view: View,
}

impl Tick {
    pub fn new(loan: &Arc<Loan>, frame: &Frame, gate: &Arc<Gate>) -> Self {
        Self {
            index: frame.tick(),
            time_s: frame.time_s(),
            encoders: frame.encoders(),
            command: frame.command(),
            has_scan: frame.ranges_m().is_some(),
            readings: frame.readings().into(),
            gate: Arc::clone(gate),
            loan: Arc::downgrade(loan),
            ranges: PyOnceLock::new(),
        }
    }

    fn over(&self, remedy: &str) -> PyErr {
        misused(format!("tick {} is over: {remedy}", self.index))
    }

    fn reply(
        &self,
        reply: Reply,
        belief: Option<(BeliefKind, Rows<'_>)>,
        last: bool,
    ) -> PyResult<()> {
        let index = self.index;
        let Some(mut turn) = self.gate.turn() else {
            let leaving = self.gate.is_leaving();
            let remedy = "another thread waits for the next one";
            return Err(self.over(if leaving { "the session is being closed" } else { remedy }));
        };
        let loan = self.loan.upgrade();
        let open = turn.part().and_then(|part| {
            let is_this = part
                .open
                .as_ref()
                .is_some_and(|open| loan.as_ref().is_some_and(|loan| Arc::ptr_eq(open, loan)));
            is_this.then_some(part)
        });
        let Some(part) = open.filter(|_| !self.gate.is_foreign()) else {
            let text = "it was answered, or the session has gone on or ended";
            return Err(misused(format!("tick {index} cannot be answered: {text}")));
        };
        if let Some(frame) = loan.as_ref().and_then(|loan| loan.held()) {
            if last {
                part.session.get_mut().end_run();
            }
            part.session.get_mut().answer(frame, reply).map_err(exception)?;
        }
        part.open = None;
        let session = part.session.get_mut();
        if let Some((kind, rows)) = belief.filter(|_| session.is_watched()) {
            let mut poses = poses_of(&rows);
            session.show_belief((index, self.time_s), kind, &mut poses);
        }
        Ok(())
    }
}

#[pymethods]
impl Tick {
    /// Encoder counts since the start, (left, right), at the end of the tick.
    #[getter]
    fn encoders(&self) -> (i64, i64) {
        (self.encoders.left, self.encoders.right)
    }

    /// The command applied during the tick, body frame: (v m/s, omega rad/s).
    #[getter]
    fn command(&self) -> (f64, f64) {
        (self.command.v_m_s, self.command.omega_rad_s)
    }

    /// The scan taken at the end of the tick: one range for each beam, m, float64
    /// of shape (beams,), read-only. None on ticks without a scan.
    ///
    /// The array lies over the frame in shared memory, without a copy. Kept past its
    /// tick it stays what it was, and so does every slice of it, even when the
    /// session or the server has ended. While 3 such arrays are kept, those of later
    /// ticks are copies.
    ///
    /// Arrays that exist at an `os.fork()` stay what they were in the fork, too: for
    /// its sake this process keeps their frames until it ends, so that later arrays
    /// of the session may be copies from then on.
    ///
    /// Raises:
    ///     RuntimeError: when it is first asked for after its tick is over, or in a
    ///         fork of the process that joined.
    #[getter]
    fn ranges(&self, py: Python<'_>) -> PyResult<Option<Py<PyArray1<f64>>>> {
        if !self.has_scan {
            return Ok(None);
        }
        let array = self.ranges.get_or_try_init(py, || {
            if self.gate.is_foreign() {
                // No process keeps the frame for a fork: the run may write over it.
                let text = "this process is a fork of the one that joined; read it before the fork";
                return Err(misused(format!("tick {}: tick.ranges: {text}", self.index)));
            }
            let remedy = "its scan has gone; read tick.ranges before the loop goes on";
            let loan = self.loan.upgrade().ok_or_else(|| self.over(remedy))?;
            array(py, loan, self.gate.views())
        })?;
        Ok(Some(array.clone_ref(py)))
    }

    /// Sectors of the bumper that touch a wall, bit k for sector k. None where the
    /// robot has no bumper.
    #[getter]
    fn bumper(&self) -> Option<u16> {
        self.readings.get().bumper()
    }

    /// What the IMU says: (yaw rate rad/s, acceleration ahead m/s^2, acceleration to
    /// the left m/s^2), body frame. None where the robot has no IMU.
    #[getter]
    fn imu(&self) -> Option<(f64, f64, f64)> {
        let imu = self.readings.get().imu()?;
        Some((imu.yaw_rate_rad_s, imu.accel_x_m_s2, imu.accel_y_m_s2))
    }

    /// Range of each sonar, m, float64 of shape (sonars,). None on ticks without.
    #[getter]
    fn sonars<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.readings.get().sonar_ranges_m().map(|ranges_m| PyArray1::from_slice(py, ranges_m))
    }

    /// Numbers of the doors that are detected, ascending. None on ticks without a
    /// reading.
    // A list of bytes would become `bytes`.
    #[getter]
    fn doors(&self) -> Option<Vec<u32>> {
        let doors = self.readings.get().doors()?;
        Some(doors.iter().map(|door| *door as u32).collect())
    }

    /// The landmarks that are seen, float64 of shape (landmarks, 3): id (-1 where it
    /// is not known), range m, bearing rad in the body frame. None on ticks without a
    /// reading.
    #[getter]
    fn landmarks<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let readings = self.readings.get();
        let Some(seen) = readings.landmarks() else { return Ok(None) };
        let numbers = &readings.numbers()[readings.numbers().len() - 3 * seen.len()..];
        PyArray1::from_slice(py, numbers).reshape([seen.len(), 3]).map(Some)
    }

    /// Answers the tick. The answer is the acknowledgement: only when all have
    /// answered does the next tick happen.
    ///
    /// Args:
    ///     x: believed position of the body in the world frame, m.
    ///     y: the same.
    ///     theta: believed heading, rad, counter-clockwise from the world x axis.
    ///     covariance: of the error tau (m, m, rad) in the tangent space at the
    ///         estimate, truth = estimate [+] tau, so along and across the body:
    ///         shape (3, 3), row by row. None: not reported.
    ///     command: (v m/s, omega rad/s) for the next tick, body frame. It moves the
    ///         robot where this participant is the driver. A command alone is an
    ///         answer as well.
    ///     innovation: (nis, degrees), how surprising this tick's measurements were:
    ///         the normalised innovation squared nu' S^-1 nu, summed over the updates
    ///         of the tick, and how many numbers were measured. None: not reported.
    ///     belief: poses that are possible now, shape (N, 3) or (N, 4): x m, y m,
    ///         theta rad, weight. They are shown on the pages and in the reports of the
    ///         run, and are no part of the answer. Not shown on a log.
    ///     last: whether the run ends with this tick, once all have answered it.
    ///         Counts where this participant is the driver.
    ///     belief_kind: "particles", or "histogram" where the poses are the cells of a
    ///         grid.
    ///
    /// Raises:
    ///     ValueError: an invalid number, by name; the tick can be answered again.
    ///     RuntimeError: the tick has been answered, or is over.
    #[pyo3(signature = (x = None, y = None, theta = None, covariance = None, command = None, innovation = None, belief = None, belief_kind = "particles", last = false))]
    #[allow(clippy::too_many_arguments, reason = "keywords of a Python function")]
    fn answer(
        &self,
        x: Option<f64>,
        y: Option<f64>,
        theta: Option<f64>,
        covariance: Option<&Bound<'_, PyAny>>,
        command: Option<(f64, f64)>,
        innovation: Option<(f64, u32)>,
        belief: Option<&Bound<'_, PyAny>>,
        belief_kind: &str,
        last: bool,
    ) -> PyResult<()> {
        let belief = belief.map(|poses| Ok::<_, PyErr>((kind(belief_kind)?, rows(poses)?)));
        let belief = belief.transpose()?;
        let command = command.map(|(v_m_s, omega_rad_s)| Twist { v_m_s, omega_rad_s });
        let pose = match (x, y, theta) {
            (Some(x), Some(y), Some(theta)) => Some(SE2::new(x, y, theta)),
            (None, None, None) => None,
            _ => return Err(PyTypeError::new_err("answer(): give x, y and theta, all three")),
        };
        let covariance = covariance.map(matrix).transpose()?;
        let innovation = innovation.map(|(nis, degrees)| Innovation { nis, degrees });
        let extra = covariance.is_some() || innovation.is_some();
        let estimate = |pose_in_world| Estimate { pose_in_world, covariance, innovation };
        let reply = match (pose.map(estimate), command) {
            (Some(estimate), None) => Reply::Estimate(estimate),
            (Some(estimate), Some(command)) => Reply::Both(estimate, command),
            (None, _) if extra => {
                let text = "answer(): a covariance or an innovation needs its pose";
                return Err(PyTypeError::new_err(text));
            }
            (None, Some(command)) => Reply::Command(command),
            (None, None) => {
                return Err(PyTypeError::new_err(
                    "answer(): give a pose or a command; or abstain()",
                ));
            }
        };
        self.reply(reply, belief, last)
    }

    /// Says nothing about this tick.
    ///
    /// Raises:
    ///     RuntimeError: the tick has been answered, or is over.
    fn abstain(&self) -> PyResult<()> {
        self.reply(Reply::Abstain, None, false)
    }

    fn __repr__(&self) -> String {
        let Self { index, encoders, .. } = self;
        let time_s = seconds(self.time_s);
        let scan = if self.has_scan { ", with a scan" } else { "" };
        format!(
            "<rusty.Tick {index} at {time_s} s, encoders ({}, {}){scan}>",
            encoders.left, encoders.right
        )
    }
}

/// The scan of a frame as an array: over the frame where it lies, or a copy where
/// the arrays over other frames would leave no place for the next tick.
fn array(py: Python<'_>, loan: Arc<Loan>, views: usize) -> PyResult<Py<PyArray1<f64>>> {
    let array = if views < MAX_VIEWS {
        let lease = Bound::new(py, Lease { view: loan.viewed() })?;
        let ranges_m = ArrayView1::from(lease.get().view.0.ranges_m().unwrap_or_default());
        // SAFETY: the ranges are in a frame that stays where it is, unchanged,
        // for as long as it is held; the array holds the lease, which holds it.
        unsafe { PyArray1::borrow_from_array(&ranges_m, lease.clone().into_any()) }
    } else {
        PyArray1::from_slice(py, loan.ranges_m().unwrap_or_default())
    };
    let locked = array.try_readwrite()?.make_nonwriteable();
    drop(locked);
    Ok(array.unbind())
}

/// The rows of a belief, as Python has them.
type Rows<'py> = PyArrayLike2<'py, f64, AllowTypeChange>;

fn kind(word: &str) -> PyResult<BeliefKind> {
    match word {
        "particles" => Ok(BeliefKind::Particles),
        "histogram" => Ok(BeliefKind::Histogram),
        _ => Err(PyValueError::new_err(format!(
            "belief_kind: {word:?} is none; give \"particles\" or \"histogram\""
        ))),
    }
}

fn rows<'py>(given: &Bound<'py, PyAny>) -> PyResult<Rows<'py>> {
    let remedy = "give numbers of shape (N, 3) or (N, 4): x, y, theta, weight";
    let rows: Rows<'py> =
        given.extract().map_err(|_| PyValueError::new_err(format!("belief: {remedy}")))?;
    let (count, columns) = rows.as_array().dim();
    if !(3..=4).contains(&columns) {
        let text = format!("belief has the shape ({count}, {columns}); {remedy}");
        return Err(PyValueError::new_err(text));
    }
    Ok(rows)
}

/// Without weights all poses are equally likely.
fn poses_of(rows: &Rows<'_>) -> Vec<WeightedPose> {
    let rows = rows.as_array();
    let equal = 1.0 / rows.nrows().max(1) as f64;
    let pose = |row: ArrayView1<'_, f64>| WeightedPose {
        x_m: row[0],
        y_m: row[1],
        theta_rad: row[2],
        weight: row.get(3).copied().unwrap_or(equal),
    };
    rows.rows().into_iter().map(pose).collect()
}

/// A 3×3 matrix, row by row, from whatever numpy makes one of.
fn matrix(given: &Bound<'_, PyAny>) -> PyResult<[f64; 9]> {
    let array: PyArrayLike2<'_, f64, AllowTypeChange> = given.extract().map_err(|_| {
        PyValueError::new_err("covariance: give numbers of shape (3, 3), row by row, or None")
    })?;
    let array = array.as_array();
    if array.dim() != (3, 3) {
        let (rows, columns) = array.dim();
        let text = format!("covariance has the shape ({rows}, {columns}); give (3, 3)");
        return Err(PyValueError::new_err(text));
    }
    Ok(std::array::from_fn(|i| array[(i / 3, i % 3)]))
}
