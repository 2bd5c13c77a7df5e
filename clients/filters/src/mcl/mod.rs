//! Monte Carlo localisation: where the robot is in a known map, by particles.
//!
//! Source: *Probabilistic Robotics*, chapter 8: Tables 8.2 (MCL), 8.3 (augmented
//! MCL) and 8.4 (KLD-sampling MCL); chapter 4, Table 4.4, for the resampling;
//! §6.4 and §6.3 for what weighs the particles. With each scan they are moved by
//! what the wheels said since the last one, weighed, and drawn anew where that
//! is called for.
//!
//! Departures, and why:
//! * The sensor is as sharp as the particles are dense, see [`sensor`].
//! * Particles are drawn anew when their weights are worth less than half of
//!   their number, or new ones are called for ([`recovery`]); the book does it at
//!   every step, and says in §4.3.4 why not to.
//! * How many are drawn follows from the bins that a low-variance sample of the
//!   present size occupies (T. Li, S. Sun, T. P. Sattar, *Adapting sample size
//!   in particle filters through KLD-resampling*, Electronics Letters 49(12),
//!   2013). Table 8.4 counts while it draws, one particle after the other, which
//!   the low-variance sampler does not. More particles never occupy fewer bins, so
//!   where the number shrinks, it is on the safe side.
//! * The answer is one mode of the belief ([`mode`]), and there is none while
//!   less than half of the belief can be said to be in one place.

mod free_space;
pub mod mode;
mod options;
mod particles;
pub mod recovery;
pub mod sensor;

use nalgebra::{Matrix3, Vector3};
use rusty_clients::{ClientError, Filter, Tick};
use rusty_contract::config::LidarConfig;
use rusty_contract::{BeliefKind, Estimate, Reply, Start, WeightedPose};
use rusty_geometry::{DiffDrive, EncoderTicks, SE2, Scan, World};

pub use free_space::FreeSpace;
pub use mode::Mode;
pub use options::{Model, Options};
pub use particles::Particles;

use self::mode::Modes;
use self::recovery::Recovery;
use self::sensor::{Sensor, Use};
use crate::kld::{Bins, sample_size};
use crate::resampling::{effective_size, low_variance};
use crate::{BeamModel, Beams, DistanceField, Motion, OccupancyMap, Odometry, Random};

/// Side of the bins that particles are counted in, m, and their number in a turn.
const BINS: (f64, u32) = (0.1, 36);
/// ε of the KLD: how far the sample may be from the belief,
const EPSILON: f64 = 0.05;
/// and the quantile of the normal law for doing so in 99 of 100 cases.
const QUANTILE: f64 = 2.326_347_874;
/// Where an initial pose is given, it is believed to be right up to this, m
const INITIAL_M: f64 = 0.05;
/// and this, rad.
const INITIAL_RAD: f64 = 0.05;
/// Particles are drawn anew when their weights are worth less than this share.
const WORTH: f64 = 0.5;
/// A share of new particles that is worth a drawing of its own.
const LOST: f64 = 0.1;
/// The largest share of them: those that have found something have to last
/// longer than a scan.
const MOST_NEW: f64 = 0.2;
/// An answer whose position has a larger σ than this, m, is none.
const NOWHERE_M: f64 = 1.0;

/// The map to localise in.
#[derive(Clone, Debug)]
pub enum Map {
    /// A floor plan.
    Plan(Box<World>),
    /// A map of cells.
    Cells(OccupancyMap),
}

/// What the filter has to know of robot and laser.
#[derive(Clone, Copy, Debug)]
pub struct Robot {
    /// Its wheels.
    pub drive: DiffDrive,
    /// Radius of its body, m.
    pub body_radius_m: f64,
    /// Its laser.
    pub lidar: LidarConfig,
}

/// Monte Carlo localisation.
#[derive(Debug)]
pub struct Mcl {
    options: Options,
    initial: Option<SE2>,
    odometry: Odometry,
    sensor: Sensor,
    space: FreeSpace,
    recovery: Recovery,
    particles: Particles,
    bins: Bins,
    modes: Modes,
    drawn: Vec<u32>,
    /// The heaviest mode after the last scan, if that is an answer.
    answer: Option<Mode>,
    /// Time of the first tick, s.
    began_s: Option<f64>,
    asleep: bool,
    motions: Random,
    draws: Random,
    places: Random,
}

impl Mcl {
    /// Begins a run.
    ///
    /// # Errors
    /// There is no map, one that cannot be used, or none that the model can use.
    pub fn of_start(start: &Start, options: &Options) -> Result<Self, ClientError> {
        let unusable = |text: String| ClientError::Unusable(text);
        let Some(spec) = &start.map else {
            return Err(unusable(
                "there is no map to localise in: give the participant `map = \"given\"` in the \
                 scenario, or a map with --map FILE.yaml"
                    .to_owned(),
            ));
        };
        let world = World::new(spec.clone()).map_err(|e| unusable(e.to_string()))?;
        let robot = Robot {
            drive: start.robot.drive,
            body_radius_m: start.robot.body_radius_m,
            lidar: start.lidar,
        };
        Self::new(robot, Map::Plan(Box::new(world)), start.initial_pose, options)
    }

    /// Begins at `initial`, or anywhere where that is not given.
    ///
    /// # Errors
    /// The map has no place for the robot, or no rays for the beam model.
    pub fn new(
        robot: Robot,
        map: Map,
        initial: Option<SE2>,
        options: &Options,
    ) -> Result<Self, ClientError> {
        let Robot { drive, body_radius_m, lidar } = robot;
        let mut model = BeamModel::of_lidar(&lidar);
        model.sigma_hit_m = options.sigma_m.unwrap_or(model.sigma_hit_m);
        let beams = Beams::new(&lidar);
        let how = Use {
            skip: options.skip as usize,
            exponent: options.exponent,
            rays: options.model == Model::Beam,
        };
        let (sensor, space) = match map {
            Map::Plan(world) => {
                let scan = Scan::new(lidar.fan());
                let space = FreeSpace::of_world(&world, body_radius_m);
                (Sensor::of_world(&world, model, beams, scan, how), space)
            }
            Map::Cells(_) if how.rays => {
                return Err(ClientError::Unusable(
                    "--model beam needs walls to cast rays at, and --map has cells: use --model \
                     field"
                        .to_owned(),
                ));
            }
            Map::Cells(map) => {
                let distances = DistanceField::of_map(&map);
                let space = FreeSpace::of_map(&map, &distances, body_radius_m);
                (Sensor::of_map(&map, &distances, &model, beams, how), space)
            }
        };
        let initial = initial.filter(|_| !options.global);
        if space.is_empty() && initial.is_none() {
            return Err(ClientError::Unusable(format!(
                "the map has no place where a body of {body_radius_m} m radius touches nothing; \
                 is it the right map?"
            )));
        }
        let random = |purpose| Random::new(options.seed, purpose);
        Ok(Self {
            options: options.clone(),
            initial,
            odometry: Odometry::new(drive, options.noise),
            sensor,
            space,
            recovery: Recovery::trusting(),
            particles: Particles::default(),
            bins: Bins::new(BINS.0, BINS.1),
            modes: Modes::default(),
            drawn: Vec::new(),
            answer: None,
            began_s: None,
            asleep: true,
            motions: random(1),
            draws: random(2),
            places: random(3),
        })
    }

    /// Takes the encoder counts at the end of a tick.
    pub fn advance(&mut self, time_s: f64, ticks: EncoderTicks) {
        let motion = *self.odometry.advance(ticks);
        let began_s = *self.began_s.get_or_insert(time_s);
        if self.asleep && time_s - began_s >= self.options.from {
            self.asleep = false;
            self.wake(&motion);
        }
    }

    /// Begins: around where it was told it stood, or everywhere.
    fn wake(&mut self, motion: &Motion) {
        let most = self.options.particles as usize;
        self.odometry.take();
        self.particles.clear();
        if let Some(initial) = self.initial {
            let variances =
                [INITIAL_M * INITIAL_M, INITIAL_M * INITIAL_M, INITIAL_RAD * INITIAL_RAD];
            let before = Matrix3::from_diagonal(&Vector3::from(variances));
            let mean = initial.compose(&motion.now_in_then);
            let covariance = motion.propagate(&before);
            self.particles.push_normal(&mean, &covariance, most, &mut self.places);
            self.answer = Some(Mode { pose_in_world: mean, covariance, share: 1.0 });
        } else {
            let poses = (0..most).filter_map(|_| self.space.pose(&mut self.places));
            poses.for_each(|pose| self.particles.push(&pose));
            self.recovery = Recovery::lost(self.sensor.expected_likelihood());
        }
        self.particles.level();
    }

    /// Takes a scan at the end of the tick that was advanced to last.
    pub fn scan(&mut self, ranges_m: &[f64]) {
        if self.asleep {
            return;
        }
        let motion = self.odometry.take();
        self.particles.move_by(&motion, &mut self.motions);
        if let Some(mode) = &mut self.answer {
            mode.covariance = motion.propagate(&mode.covariance);
            mode.pose_in_world = mode.pose_in_world.compose(&motion.now_in_then);
        }
        let Some(weighed) = self.sensor.weigh(ranges_m, &mut self.particles) else {
            return;
        };
        self.recovery.update(weighed.beam_likelihood);
        let lost = self.recovery.share();
        let new = lost.min(MOST_NEW);
        let known = |mode: &Mode| {
            let variance_m2 = mode.covariance[(0, 0)].max(mode.covariance[(1, 1)]);
            mode.share * (1.0 - lost) >= 0.5 && variance_m2 <= NOWHERE_M * NOWHERE_M
        };
        self.answer = self.modes.heaviest(&self.particles).filter(known);
        let worth = effective_size(&self.particles.weights);
        if worth < WORTH * self.particles.count() as f64 || new > LOST {
            self.draw(new, weighed.spread);
        }
    }

    /// Draws the next generation, `new` of which come from everywhere.
    fn draw(&mut self, new: f64, spread: (f64, f64)) {
        let (least, most) = (self.options.particles_min as usize, self.options.particles as usize);
        let weights = &self.particles.weights;
        low_variance(weights, weights.len(), self.draws.uniform(), &mut self.drawn);
        let drawn = self.drawn.iter().map(|k| self.particles.pose(*k as usize));
        let needed = sample_size(self.bins.fill(drawn), EPSILON, QUANTILE).max(least);
        let count = ((needed as f64 / (1.0 - new).max(1e-3)) as usize).min(most).max(1);
        let strangers = if self.space.is_empty() { 0.0 } else { new * count as f64 };
        let strangers = (strangers + self.draws.uniform()) as usize;
        let kept = count.saturating_sub(strangers);
        low_variance(weights, kept, self.draws.uniform(), &mut self.drawn);
        self.particles.replace(&self.drawn, spread, &mut self.draws);
        for _ in kept..count {
            if let Some(pose) = self.space.pose(&mut self.places) {
                self.particles.push(&pose);
            }
        }
        self.particles.level();
    }

    /// Where the robot is and how sure that is: after the last scan, carried on
    /// by the wheels. `None` while there is no idea.
    #[must_use]
    pub fn answer(&self) -> Option<Estimate> {
        let mode = self.answer.as_ref()?;
        let motion = self.odometry.so_far();
        let p = motion.propagate(&mode.covariance);
        let p = 0.5 * (p + p.transpose());
        let estimate = Estimate::new(mode.pose_in_world.compose(&motion.now_in_then));
        let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| p[(i, j)]));
        let mut covariance = [0.0; 9];
        covariance.copy_from_slice(rows.as_flattened());
        Some(estimate.with_covariance(covariance))
    }

    /// The particles as they are after the last scan.
    #[must_use]
    pub fn particles(&self) -> &Particles {
        &self.particles
    }
}

impl Filter for Mcl {
    fn tick(&mut self, tick: &Tick<'_>) -> Reply {
        self.advance(tick.time_s(), tick.ticks());
        if let Some(ranges_m) = tick.ranges_m() {
            self.scan(ranges_m);
        }
        self.answer().map_or(Reply::Abstain, Reply::Estimate)
    }

    fn belief(&self, poses: &mut Vec<WeightedPose>) -> Option<BeliefKind> {
        let since = self.odometry.so_far().now_in_then;
        poses.extend(self.particles.poses().zip(&self.particles.weights).map(|(pose, &weight)| {
            let now = pose.compose(&since);
            WeightedPose { x_m: now.x(), y_m: now.y(), theta_rad: now.theta(), weight }
        }));
        Some(BeliefKind::Particles)
    }
}
