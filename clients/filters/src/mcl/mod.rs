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
//!   their number; the book does it at every step, and says in §4.3.4 why not to.
//! * How many are drawn follows from the bins that a low-variance sample of the
//!   present size occupies (T. Li, S. Sun, T. P. Sattar, *Adapting sample size
//!   in particle filters through KLD-resampling*, Electronics Letters 49(12),
//!   2013), spread as those that are kept will be. Table 8.4 counts while it
//!   draws, one particle after the other, which the low-variance sampler does not.
//!   More particles never occupy fewer bins, so where the number shrinks, it is on
//!   the safe side.
//! * A place is counted once, however long the robot stands there: the module
//!   `cloud` says why, and what is asked of its other scans.
//! * New particles from everywhere are not mixed with the old ones, see
//!   [`search`]. Where they are too few for a building, scans are looked up at all
//!   poses of the map, see [`everywhere`] and `hypotheses`.
//! * The answer is one mode of the belief ([`mode`]), and there is none while
//!   less than half of the belief can be said to be in one place: the share of its
//!   heaviest mode, times w_fast / w_slow of [`recovery`]; nor while a second mode has
//!   more than a twentieth.
//! * It abstains where few of the walls in view are on the map. After a way without them, the
//!   robot is looked for as at the beginning: see the module `known_walls`.
//! * Where the scan says that something holds the robot while its wheels turn, every second
//!   particle stays behind, see the module `held`.
//! * Modes are weighed and drawn each for itself, so that only the likelihood decides
//!   between them: see the module `strata`.
//! * Particles that fit lie evenly in the directions that no scan sees, and errors of the wheels
//!   have heavier tails than normal ones: see the module `even`.
//! * Each particle has a scale of the wheels' distances as well, so that worn wheels do not lead
//!   them astray along a corridor.

mod cloud;
mod even;
pub mod everywhere;
mod free_space;
mod hypotheses;
mod known_walls;
mod lost;
pub mod mode;
mod options;
mod particles;
mod prepared;
mod rays;
pub mod recovery;
pub mod search;
pub mod sensor;
mod strata;

use nalgebra::{Matrix3, Vector3};
use rusty_clients::{ClientError, Filter, Tick};
use rusty_contract::{BeliefKind, Estimate, Reply, Start, WeightedPose, errln};
use rusty_geometry::{EncoderCounts, SE2};

pub use free_space::FreeSpace;
pub use mode::Mode;
pub(crate) use mode::is_somewhere;
pub(crate) use options::LEAST_HIT;
pub use options::{Model, Options, Reading};
pub use particles::Particles;
pub(crate) use particles::root;
pub use prepared::{Map, Prepared, Robot};

use self::cloud::Cloud;
use self::hypotheses::Hypotheses;
use self::known_walls::KnownWalls;
use self::mode::Modes;
use self::recovery::Recovery;
use self::search::Search;
use self::sensor::Sensor;
use crate::held::Holding;
use crate::moment::RunClock;
use crate::tangent::{estimate, placed};
use crate::{Motion, Odometry, Random};

/// Where an initial pose is given, it is believed to be right up to this, m
const INITIAL_M: f64 = 0.05;
/// and this, rad.
const INITIAL_RAD: f64 = 0.05;
/// From this share of Table 8.3 on, the robot is looked for elsewhere as well.
const LOST: f64 = 0.05;
/// The largest share of the belief that a second place has during an answer.
const RIVAL: f64 = 0.05;

/// Monte Carlo localisation.
#[derive(Debug)]
pub struct Mcl {
    options: Options,
    initial: Option<SE2>,
    odometry: Odometry,
    sensor: Sensor,
    space: FreeSpace,
    recovery: Recovery,
    known_walls: KnownWalls,
    holding: Holding,
    belief: Cloud,
    search: Search,
    /// None while it looks around one place only.
    hypotheses: Option<Hypotheses>,
    modes: Modes,
    /// The heaviest mode after the last scan,
    mode: Option<Mode>,
    /// and whether that is an answer.
    is_known: bool,
    /// Whether the last search found another place that explains the scans as well.
    is_contested: bool,
    /// Whether it was told where it is, or knows it from scans of several places.
    is_found: bool,
    clock: RunClock,
    dt_s: f64,
    asleep: bool,
    places: Random,
}

impl Mcl {
    /// Begins a run.
    ///
    /// # Errors
    /// There is no map, one that cannot be used, or none that the model can use.
    pub fn of_start(start: &Start, options: &Options) -> Result<Self, ClientError> {
        Self::of_next_start(start, options, &mut None)
    }

    /// Begins a run, the fields of whose map take long to make: those of `prepared` are
    /// taken where all is told that was told then, and kept there for the next run.
    ///
    /// # Errors
    /// As [`of_start`](Self::of_start).
    pub fn of_next_start(
        start: &Start,
        options: &Options,
        prepared: &mut Option<Prepared>,
    ) -> Result<Self, ClientError> {
        let robot = Robot::of_start(start);
        let parts = Prepared::parts(&robot, start, options, prepared)?;
        Self::begin(robot, parts, start.initial_pose, options)
    }

    /// Begins at `initial`, or anywhere where that is not given.
    ///
    /// # Errors
    /// The map has no place for the robot, or no rays for the beam model; or the
    /// fewest particles are more than the most.
    pub fn new(
        robot: Robot,
        map: Map,
        initial: Option<SE2>,
        options: &Options,
    ) -> Result<Self, ClientError> {
        let parts = prepared::sense(&robot, map, options)?;
        Self::begin(robot, parts, initial, options)
    }

    fn begin(
        robot: Robot,
        (sensor, space): (Sensor, FreeSpace),
        initial: Option<SE2>,
        options: &Options,
    ) -> Result<Self, ClientError> {
        let Robot { drive, body_radius_m, lidar, dt_s } = robot;
        let initial = options.at.or(initial.filter(|_| !options.global));
        if space.is_empty() && initial.is_none() {
            return Err(ClientError::Unusable(format!(
                "the map has no place where a body of {body_radius_m} m radius touches nothing; \
                 is it the right map?"
            )));
        }
        Ok(Self {
            options: options.clone(),
            initial,
            odometry: Odometry::new(drive, options.noise),
            sensor,
            space,
            recovery: Recovery::trusting(),
            known_walls: KnownWalls::default(),
            holding: Holding::default(),
            belief: Cloud::new(options.seed, 2),
            search: Search::new(options.seed),
            hypotheses: Some(Hypotheses::of_view(lidar.fov_rad)),
            modes: Modes::default(),
            mode: None,
            is_known: false,
            is_contested: false,
            is_found: initial.is_some(),
            clock: RunClock::default(),
            dt_s,
            asleep: true,
            places: Random::new(options.seed, 1),
        })
    }

    /// Takes the encoder counts at the end of a tick.
    pub fn advance(&mut self, time_s: f64, ticks: EncoderCounts) {
        let motion = *self.odometry.advance(ticks);
        let now = self.clock.tick(time_s, self.dt_s);
        if self.asleep && now.is_from(self.options.from) {
            self.asleep = false;
            self.wake(&motion);
        }
    }

    /// Begins: around where it was told it stood, or everywhere.
    fn wake(&mut self, motion: &Motion) {
        let most = self.options.particles as usize;
        self.odometry.take();
        let particles = &mut self.belief.particles;
        if let Some(initial) = self.initial {
            let variances =
                [INITIAL_M * INITIAL_M, INITIAL_M * INITIAL_M, INITIAL_RAD * INITIAL_RAD];
            let before = Matrix3::from_diagonal(&Vector3::from(variances));
            // Where it is told to begin, it is when it wakes up.
            let motion = if self.options.at.is_some() { &Motion::default() } else { motion };
            let mean = initial.compose(&motion.now_in_then);
            let covariance = motion.propagate(&before);
            particles.push_normal(&mean, &covariance, most, &mut self.places);
            self.mode =
                Some(Mode { pose_in_world: mean, covariance, share: 1.0, second_share: 0.0 });
            self.is_known = true;
        } else {
            self.space.fill(particles, most, &mut self.places);
            self.recovery = Recovery::lost(self.sensor.expected_likelihood());
        }
        self.belief.particles.level();
    }

    /// Forgets the belief, and looks for the robot around a pose with this covariance
    /// (m, m, rad). For a filter that is awake.
    pub fn look_around(&mut self, pose_in_world: &SE2, covariance: &Matrix3<f64>) {
        let most = self.options.particles as usize;
        self.belief.clear();
        self.belief.particles.push_normal(pose_in_world, covariance, most, &mut self.places);
        self.belief.particles.level();
        self.recovery = Recovery::lost(self.sensor.expected_likelihood());
        self.known_walls = KnownWalls::default();
        self.hypotheses = None;
        self.mode = None;
        self.is_known = false;
    }

    /// Takes a scan at the end of the tick that was advanced to last.
    pub fn scan(&mut self, ranges_m: &[f64]) {
        if self.asleep {
            return;
        }
        let wheels = self.odometry.take();
        let scaled = self.belief.particles.scaled(&wheels);
        let is_followed = self.is_found && self.belief.scans > 0;
        let held = if let Some(from) = self.mode.filter(|_| is_followed) {
            let look = |poses: &_, _| self.sensor.look_at(ranges_m, poses);
            self.holding.ask(&from.pose_in_world, &scaled, look)
        } else {
            self.holding = Holding::default();
            None
        };
        let motion = held.unwrap_or(scaled);
        let of_particles = held.unwrap_or(wheels);
        let is_near = self.is_known || self.hypotheses.is_none();
        self.belief.move_by(&[wheels, of_particles], is_near);
        self.search.move_by(&of_particles);
        self.known_walls.move_by(&motion);
        if let Some(hypotheses) = &mut self.hypotheses {
            hypotheses.move_by(&motion);
        }
        if let Some(mode) = &mut self.mode {
            mode.covariance = motion.propagate(&mode.covariance);
            mode.pose_in_world = mode.pose_in_world.compose(&motion.now_in_then);
        }
        if !self.belief.weigh(&mut self.sensor, ranges_m) {
            return;
        }
        self.recovery.update(self.belief.seen_likelihood(&self.sensor, ranges_m));
        let is_in_doubt = self.recovery.share() > LOST;
        let is_placed = (is_in_doubt || !self.is_found) && self.compare_places(ranges_m);
        if is_in_doubt && !is_placed {
            self.look_elsewhere(ranges_m);
        } else {
            self.search.give_up();
            self.is_contested = false;
        }
        self.mode = self.modes.heaviest(&self.belief.particles);
        if let Some(mode) = self.mode {
            self.look_for_walls(&mode);
        }
        let trusted = 1.0 - self.recovery.share();
        let known = |mode: &Mode| {
            let is_likely = mode.share * trusted >= 0.5 && mode.second_share <= RIVAL;
            let is_on_map = !self.known_walls.are_few();
            is_likely && is_on_map && !self.is_contested && is_somewhere(&mode.covariance)
        };
        // A filter that began lost compares all places before it answers.
        let places = self.hypotheses.as_ref().filter(|_| !self.is_found);
        let agrees = |mode: &Mode| places.is_none_or(|places| places.agree(mode));
        self.is_known = self.mode.as_ref().is_some_and(|mode| known(mode) && agrees(mode));
        self.belief.draw(&self.options, self.is_known);
    }

    /// Where the robot is and how sure that is: after the last scan, carried on
    /// by the wheels. `None` while there is no idea.
    pub fn answer(&self) -> Option<Estimate> {
        let mode = self.mode.as_ref().filter(|_| self.is_known)?;
        let wheels = self.belief.particles.scaled(self.odometry.so_far());
        let motion = self.holding.until_next(|| wheels).unwrap_or(wheels);
        let (pose, covariance) = placed(&mode.pose_in_world, &mode.covariance, &motion);
        Some(estimate(&pose, &covariance))
    }

    /// The particles as they are after the last scan.
    pub fn particles(&self) -> &Particles {
        &self.belief.particles
    }
}

impl Filter for Mcl {
    const SHOWS_BELIEF: bool = true;

    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        self.advance(tick.time_s(), tick.encoders());
        if let Some(ranges_m) = tick.ranges_m() {
            self.scan(ranges_m);
        }
        self.answer().map_or(Reply::Abstain, Reply::Estimate)
    }

    fn finish(self) -> Result<(), ClientError> {
        if self.asleep && self.clock.is_running() {
            errln!("mcl answered nothing: the run ended before --from {}", self.options.from);
        }
        Ok(())
    }

    fn belief(&self, poses: &mut Vec<WeightedPose>) -> Option<BeliefKind> {
        let since = self.belief.particles.scaled(self.odometry.so_far()).now_in_then;
        let particles = &self.belief.particles;
        poses.extend(particles.poses().zip(&particles.weights).map(|(pose, &weight)| {
            let now = pose.compose(&since);
            WeightedPose { x_m: now.x(), y_m: now.y(), theta_rad: now.theta(), weight }
        }));
        Some(BeliefKind::Particles)
    }
}

#[cfg(test)]
mod tests;
