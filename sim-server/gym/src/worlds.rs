//! Worlds that are stepped together, and the arrays of Python that they are written to.

use numpy::{
    Element, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray, PyReadwriteArray1,
    PyReadwriteArray2,
};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use rusty_contract::Frame;
use rusty_engine::scenario_file;
use rusty_geometry::Twist;

use crate::lane::Lane;
use crate::layout::{Layout, command_limits};

/// The most worlds of one object.
const MAX_WORLDS: usize = 1 << 16;
/// The most threads of one object.
const MAX_THREADS: usize = 1 << 10;

/// The fewest worlds that are worth another thread's attention.
const MIN_LANES: usize = 32;

/// Worlds of one scenario, which differ in their seeds. Results do not depend on the
/// number of threads.
#[pyclass(module = "rusty._gym")]
pub struct Worlds {
    layout: Layout,
    lanes: Vec<Lane>,
    /// `None` with one thread: the caller's.
    pool: Option<ThreadPool>,
    /// The process that has the threads.
    process_id: u32,
}

#[pymethods]
impl Worlds {
    /// Makes `count` worlds of a scenario (name or file), each before its first tick with
    /// the scenario's seed; `changes` are those of `--set`.
    #[new]
    fn new(scenario: &str, changes: Vec<String>, count: usize, threads: usize) -> PyResult<Self> {
        within("num_envs", count, MAX_WORLDS)?;
        within("threads", threads, MAX_THREADS)?;
        let loaded = scenario_file::load(scenario, &changes).map_err(refused)?;
        let config = loaded.config_with(rusty_floorplan::read).map_err(refused)?;
        let layout = Layout::of(&config);
        let lanes = vec![Lane::new(config, &layout).map_err(refused)?; count];
        let pool = match threads.min(count) {
            1 => None,
            threads => {
                let name = |index| format!("rusty-gym-{index}");
                let pool = ThreadPoolBuilder::new().num_threads(threads).thread_name(name).build();
                Some(pool.map_err(|e| PyRuntimeError::new_err(format!("threads: {e}")))?)
            }
        };
        Ok(Self { layout, lanes, pool, process_id: std::process::id() })
    }

    /// The parts of an observation, in order: name, shape, least and greatest number.
    #[getter]
    fn layout(&self) -> Vec<(&'static str, Vec<usize>, f64, f64)> {
        let parts = self.layout.parts().iter();
        parts.map(|p| (p.name, p.shape.clone(), p.bounds[0], p.bounds[1])).collect()
    }

    /// Greatest v_m_s and omega_rad_s that the wheels can follow, each alone.
    #[getter]
    fn command_limits(&self) -> [f64; 2] {
        command_limits(self.lanes[0].config())
    }

    /// Length of a tick, s.
    #[getter]
    fn dt_s(&self) -> f64 {
        self.lanes[0].config().dt_s
    }

    /// Number of ticks of the scenario.
    #[getter]
    fn ticks(&self) -> u64 {
        self.lanes[0].config().ticks
    }

    /// The seed of each world.
    #[getter]
    fn seeds(&self) -> Vec<u64> {
        self.lanes.iter().map(|lane| lane.config().seed).collect()
    }

    /// For each world, the run digest and the world digest of its ticks, 32 hexadecimal
    /// digits each.
    #[getter]
    fn digests(&self) -> Vec<(String, String)> {
        let digests = self.lanes.iter().map(Lane::digest);
        digests.map(|digest| (digest.run_hex(), digest.world_hex())).collect()
    }

    /// Puts the worlds of `mask` back before their first tick, each with its seed.
    fn restart(
        &mut self,
        mask: PyReadonlyArray1<'_, bool>,
        seeds: PyReadonlyArray1<'_, u64>,
    ) -> PyResult<()> {
        let count = self.lanes.len();
        let (mask, seeds) =
            (sized("mask", mask.as_slice()?, count)?, sized("seeds", seeds.as_slice()?, count)?);
        let chosen = self.lanes.iter_mut().zip(mask.iter().zip(seeds));
        for (lane, (_, seed)) in chosen.filter(|(_, (is_chosen, _))| **is_chosen) {
            lane.restart(*seed, &self.layout).map_err(|e| {
                PyValueError::new_err(format!("reset with seed {seed} failed: {e}"))
            })?;
        }
        Ok(())
    }

    /// Makes a tick in each world that is not in `skipped`, with its row of `commands`
    /// (v_m_s, omega_rad_s), which must be finite.
    fn step(
        &mut self,
        py: Python<'_>,
        commands: PyReadonlyArray2<'_, f64>,
        skipped: PyReadonlyArray1<'_, bool>,
    ) -> PyResult<()> {
        let count = self.lanes.len();
        let (commands, _) = sized("actions", commands.as_slice()?, 2 * count)?.as_chunks::<2>();
        let skipped = sized("skipped", skipped.as_slice()?, count)?;
        let Self { layout, lanes, pool, process_id } = self;
        let step = |frame: &mut Box<Frame>, (lane, (command, skipped)): Assigned<'_>| {
            if !skipped {
                let [v_m_s, omega_rad_s] = *command;
                lane.step(Twist { v_m_s, omega_rad_s }, layout, frame);
            }
        };
        match pool {
            None => py.detach(|| {
                let mut frame = Frame::boxed();
                let work = lanes.iter_mut().zip(commands.iter().zip(skipped));
                work.for_each(|assigned| step(&mut frame, assigned));
            }),
            Some(_) if *process_id != std::process::id() => {
                return Err(PyRuntimeError::new_err(
                    "step failed: expected the process that made the environments, got a fork of \
                     it, which has none of their threads; make them in this process",
                ));
            }
            Some(pool) => py.detach(|| {
                pool.install(|| {
                    let work = lanes.par_iter_mut().zip(commands.par_iter().zip(skipped));
                    work.with_min_len(MIN_LANES).for_each_init(Frame::boxed, step);
                });
            }),
        }
        Ok(())
    }

    /// Writes what was seen last, a row for each world: observations (n, width) in the
    /// order of the layout; true poses (n, 3), world frame; whether the robot was blocked;
    /// numbers of ticks; digests of frames (0 before the first).
    fn observe(
        &self,
        observations: PyReadwriteArray2<'_, f32>,
        truth: PyReadwriteArray2<'_, f64>,
        blocked: PyReadwriteArray1<'_, bool>,
        ticks: PyReadwriteArray1<'_, u64>,
        digests: PyReadwriteArray1<'_, u64>,
    ) -> PyResult<()> {
        let width = self.lanes[0].row().len();
        self.write(observations, width, |lane, row| row.copy_from_slice(lane.row()))?;
        self.write(truth, 3, |lane, pose| pose.copy_from_slice(&lane.truth()))?;
        self.write(blocked, 1, |lane, place| place[0] = lane.is_blocked())?;
        self.write(ticks, 1, |lane, place| place[0] = lane.tick_count())?;
        self.write(digests, 1, |lane, place| place[0] = lane.frame_digest())
    }
}

/// A world, its command, and whether it is skipped.
type Assigned<'a> = (&'a mut Lane, (&'a [f64; 2], &'a bool));

impl Worlds {
    /// Writes `width` numbers of each world with `put`.
    fn write<T: Element, D: numpy::ndarray::Dimension>(
        &self,
        mut array: PyReadwriteArray<'_, T, D>,
        width: usize,
        put: impl Fn(&Lane, &mut [T]),
    ) -> PyResult<()> {
        let numbers = array.as_slice_mut()?;
        sized("an output", numbers, width * self.lanes.len())?;
        self.lanes.iter().zip(numbers.chunks_exact_mut(width)).for_each(|(l, n)| put(l, n));
        Ok(())
    }
}

/// Checks the length of an array.
fn sized<'a, T>(name: &str, numbers: &'a [T], expected: usize) -> PyResult<&'a [T]> {
    let got = numbers.len();
    let message = || format!("{name}: expected {expected} numbers, got {got}");
    (got == expected).then_some(numbers).ok_or_else(|| PyValueError::new_err(message()))
}

/// Checks a number of things.
fn within(name: &str, value: usize, most: usize) -> PyResult<()> {
    let message = || format!("{name}: expected 1 to {most}, got {value}");
    (1..=most).contains(&value).then_some(()).ok_or_else(|| PyValueError::new_err(message()))
}

/// The exception for a scenario that cannot be used.
fn refused(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}
