//! Runs without client processes: the world, and dead reckoning on what its
//! frames show, in this process.
//!
//! The arithmetic is that of the client `dead-reckoning` (encoder counts to a
//! pose by `odometry_delta` and ⊞), of the server's run digest and of the
//! scorer, so a row is what `launch` comes to with this seed, to the bit. What
//! is not done: nothing is sealed, sent or kept but what a row is made of.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rusty_contract::score::Figures;
use rusty_contract::{Frame, Reply, RunDigest};
use rusty_geometry::{DiffDrive, EncoderCounts, SE2, odometry_delta};
use rusty_metrics::{Errors, Held, PathLength};
use rusty_sim::Sim;

use super::error::SweepError;
use super::plan::{Plan, Sampling};
use super::record::Record;
use super::row::Row;
use super::short::ShortBeams;
use super::track::{Sample, Track};
use super::workers::Maker;

/// The estimator that runs inside.
pub const ESTIMATOR: &str = "dead-reckoning";

/// Ticks between two looks at whether to stop.
const TICKS_BETWEEN_LOOKS: u64 = 4096;

/// The world of a cell.
struct CellWorld {
    index: usize,
    sim: Sim,
    beams: Option<ShortBeams>,
}

/// One worker's world, frame and sums, used for one run after the other: a tick
/// allocates nothing.
pub struct Inside<'p> {
    plan: &'p Plan,
    stop: &'p AtomicBool,
    ticks_done: &'p AtomicU64,
    world: Option<CellWorld>,
    frame: Box<Frame>,
    errors: Errors,
}

impl<'p> Inside<'p> {
    /// A worker for the runs of `plan`. It counts its ticks, and leaves a run
    /// once it is asked to stop.
    #[must_use]
    pub fn new(plan: &'p Plan, stop: &'p AtomicBool, ticks_done: &'p AtomicU64) -> Self {
        let (frame, errors) = (Frame::boxed(), Errors::default());
        Self { plan, stop, ticks_done, world: None, frame, errors }
    }
}

impl Maker for Inside<'_> {
    fn make(&mut self, run: u64) -> Result<Option<Record>, SweepError> {
        let (cell, seed) = self.plan.place(run);
        let CellWorld { sim, beams, .. } = match &mut self.world {
            Some(world) if world.index == cell => world,
            world => {
                let sim = self.plan.worlds[cell].clone();
                let beams = ShortBeams::of(sim.config(), sim.world());
                world.insert(CellWorld { index: cell, sim, beams })
            }
        };
        sim.restart(seed);
        beams.iter_mut().for_each(ShortBeams::clear);
        self.errors.clear();
        let mut reckoned = Reckoned::new(sim, self.plan.sampling(run));
        for tick in 0..sim.config().ticks {
            reckoned.step(sim, &mut self.frame, &mut self.errors);
            beams.iter_mut().for_each(|beams| beams.push(&self.frame, &sim.truth()));
            if (tick + 1).is_multiple_of(TICKS_BETWEEN_LOOKS) {
                self.ticks_done.fetch_add(TICKS_BETWEEN_LOOKS, Ordering::Relaxed);
                if self.stop.load(Ordering::Relaxed) {
                    return Ok(None);
                }
            }
        }
        let ticks = sim.tick();
        self.ticks_done.fetch_add(ticks % TICKS_BETWEEN_LOOKS, Ordering::Relaxed);
        let place = Place { cell, seed, estimator: ESTIMATOR.to_owned() };
        let mut row = place.row(&self.errors.figures());
        row.ticks = ticks;
        row.time_s = self.frame.time_s();
        row.distance_m = reckoned.path.metres();
        row.blocked_ticks = Some(reckoned.held.tick_count());
        row.z_short = beams.as_ref().map_or(f64::NAN, ShortBeams::share);
        row.digest = reckoned.digest.run_hex();
        let tracks = match reckoned.samples.is_empty() {
            true => Vec::new(),
            false => vec![place.track(reckoned.samples)],
        };
        Ok(Some(Record { run, rows: vec![row], tracks, lost: None }))
    }
}

/// Whose figures they are.
pub(crate) struct Place {
    pub cell: usize,
    pub seed: u64,
    pub estimator: String,
}

impl Place {
    /// A row with these figures; what is not among them is for the caller to add.
    pub fn row(&self, figures: &Figures) -> Row {
        let or_nan = |figure: Option<f64>| figure.unwrap_or(f64::NAN);
        Row {
            cell: self.cell,
            seed: self.seed,
            parameters: [].into(),
            estimator: self.estimator.clone(),
            ticks: 0,
            time_s: 0.0,
            distance_m: 0.0,
            final_position_error_m: or_nan(figures.final_position_error_m),
            final_heading_error_rad: or_nan(figures.final_heading_error_rad),
            mean_position_error_m: or_nan(figures.mean_position_error_m),
            ate_rmse_m: or_nan(figures.ate_rmse_m),
            p95_position_error_m: or_nan(figures.p95_position_error_m),
            max_position_error_m: or_nan(figures.max_position_error_m),
            rmse_heading_error_rad: or_nan(figures.rmse_heading_error_rad),
            max_heading_error_rad: or_nan(figures.max_heading_error_rad),
            blocked_ticks: None,
            z_short: f64::NAN,
            digest: String::new(),
            clients: None,
        }
    }

    /// A track with these samples.
    pub fn track(&self, samples: Vec<Sample>) -> Track {
        let estimator = self.estimator.clone();
        Track { cell: self.cell, seed: self.seed, estimator, samples }
    }
}

/// Dead reckoning on the way.
struct Reckoned {
    drive: DiffDrive,
    pose_in_world: SE2,
    last: EncoderCounts,
    digest: RunDigest,
    path: PathLength,
    held: Held,
    sampling: Sampling,
    next_sample: u64,
    samples: Vec<Sample>,
}

impl Reckoned {
    fn new(sim: &Sim, mut sampling: Sampling) -> Self {
        let carried_at = sim.config().kidnappings.iter().map(|k| k.tick).collect();
        Self {
            drive: sim.config().robot.nominal().drive,
            pose_in_world: sim.config().start,
            last: EncoderCounts::default(),
            digest: RunDigest::default(),
            path: PathLength::new(Some(sim.config().start), carried_at),
            held: Held::of_run(sim.config(), &sim.config().kidnappings),
            samples: Vec::with_capacity(sampling.count()),
            next_sample: sampling.next_tick(),
            sampling,
        }
    }

    /// One tick of the world and of the estimator.
    fn step(&mut self, sim: &mut Sim, frame: &mut Frame, errors: &mut Errors) {
        let tick = sim.tick();
        let _ = sim.step(None, frame);
        let truth = sim.truth();
        self.held.push(tick, Some(truth), frame.command());
        frame.write_digest(true);
        self.digest.absorb_frame(frame, Some(truth));
        let delta = odometry_delta(self.last, frame.encoders(), &self.drive);
        self.pose_in_world = self.pose_in_world.boxplus(&delta);
        self.last = frame.encoders();
        self.digest.absorb_replies(std::iter::once(Reply::from(self.pose_in_world)));
        // As the scorer has it: poses made of numbers count.
        if truth.is_finite() {
            self.path.push(tick, &truth);
            if self.pose_in_world.is_finite() {
                errors.push(&self.pose_in_world, &truth);
            }
        }
        if tick == self.next_sample {
            self.samples.push(Sample {
                time_s: frame.time_s(),
                distance_m: self.path.metres(),
                truth,
                estimate: self.pose_in_world,
                nees: None,
            });
            self.next_sample = self.sampling.next_tick();
        }
    }
}
