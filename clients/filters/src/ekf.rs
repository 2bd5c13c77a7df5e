//! EKF localisation: where on this floor plan, by straight walls.
//!
//! Source: *Probabilistic Robotics*, §7.4 and §7.5, Tables 7.2 and 7.3 (EKF
//! localisation with unknown correspondences): predict by the odometry; find the
//! features of the scan; match each to the map by the Mahalanobis distance of its
//! innovation, within a gate (§7.5.2); update. The features are lines, as in
//! R. Siegwart, I. Nourbakhsh, *Introduction to Autonomous Mobile Robots* (2004),
//! §5.6.3: [`crate::lines`] finds them, [`crate::line_map`] knows the map's.
//!
//! Departures, and why:
//! * The state is a pose of SE(2), and its error a tangent vector at it: truth =
//!   estimate ⊞ τ (J. Solà et al., arXiv:1812.01537). No angle is ever subtracted
//!   from another across ±π, and the covariance is in the robot's own axes.
//! * The book takes the likeliest match. A piece of wall that two lines of the
//!   map could be is left out: a wrong match is worse than none.
//! * A match must also lie where the map has a wall, not only on its line.
//! * The covariance is updated in Joseph's form, (I − KH) P (I − KH)ᵀ + K R Kᵀ,
//!   which stays symmetric and positive whatever is rounded (Bar-Shalom et al.,
//!   *Estimation with Applications to Tracking and Navigation*, 2001, §5.2.3),
//!   and is then carried to the tangent space at the updated pose.
//! * Of a line, its direction and the place of its best known point are compared,
//!   not α and ρ: see [`crate::line_map::LineInnovation`].
//! * Corners and door posts are no features. Along a corridor its side walls say
//!   nothing; but its ends and what is seen through doorways do: over 100 seeds in
//!   the Apartment's corridor the errors along it were 0.7 to 1.6 mm (standard
//!   deviation), those across 0.4 to 0.5 mm. A door post is known to about half
//!   the distance between two beams, centimetres, and its error is not normal.
//! * Without further means an EKF that diverges is wrong and sure of it. Here a test of
//!   the innovations (`monitor`) adds the constant errors of the wheels to the state
//!   (`wheels`) and raises the process noise. Where a scan says that something holds the
//!   robot while its wheels turn (`held`), the way since the last scan is predicted anew. A
//!   test of the beams' ends (`search`) finds a lost robot again, and makes the filter
//!   abstain until then. A filter that passes these tests has the bits of one without them.
//! * Matches are found before the first update, updates are one after the other,
//!   each linearised where the last one led.

mod monitor;
mod search;
mod wheels;

use clap::Args;
use nalgebra::Matrix3;
use rusty_clients::{ClientError, Filter, Tick};
use rusty_contract::{Estimate, Innovation, Reply, Start, errln};
use rusty_geometry::{EncoderCounts, SE2};

use self::monitor::{Monitor, Verdict};
use self::search::Watch;
use self::wheels::WheelErrors;
use crate::beams::believed_lidar;
use crate::held::Holding;
use crate::line_map::{Gate, LineInnovation, LineMap, MapLine};
use crate::lines::{Extraction, Segment};
use crate::motion::Steps;
use crate::numbers::{positive, probability};
use crate::start_options::StartOptions;
use crate::tangent::{estimate, placed, right_jacobian, symmetric};
use crate::{Beams, Motion, OdometryNoise};

/// The smallest σ that is believed of a range, m: a laser without any error
/// would leave nothing to divide by.
const LEAST_RANGE_STD_M: f64 = 1e-4;
/// The smallest σ of a range in a search, m: sharper fields take too much memory.
const LEAST_MCL_STD_M: f64 = 0.01;
/// The greatest factor by which a failed test widens the covariance.
const MOST_WIDENED: f64 = 4.0;

/// Localise on a floor plan with an extended Kalman filter
///
/// The EKF (Probabilistic Robotics, chapter 7) predicts from the encoders, finds
/// the straight walls in each scan, matches them to the map, and corrects. It
/// needs the initial pose. Without a map it only predicts. It answers every tick
/// with a pose and a covariance, and reports the innovation (NIS) of each scan.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// What is believed of the wheels.
    #[command(flatten)]
    pub odometry: OdometryNoise,

    /// What is believed of the walls.
    #[command(flatten)]
    pub walls: WallOptions,

    /// What is believed of the start.
    #[command(flatten)]
    pub start: StartOptions,
}

/// What is believed of the walls in a scan.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
#[command(next_help_heading = "Walls")]
pub struct WallOptions {
    /// Standard deviation of a range, m [default: the data sheet's, or 0.03]
    #[arg(long, value_name = "METRES", value_parser = positive)]
    pub range_std_m: Option<f64>,

    /// Minimum number of points of a wall
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u64).range(3..))]
    pub min_points: u64,

    /// Minimum length of a wall, m
    #[arg(long, value_name = "METRES", default_value_t = 0.4, value_parser = positive)]
    pub min_length_m: f64,

    /// Probability that the gate accepts a correct match
    #[arg(long, value_name = "P", default_value_t = 0.999, value_parser = probability)]
    pub gate: f64,

    /// Minimum share of a wall piece that the map must cover
    #[arg(long, value_name = "SHARE", default_value_t = 0.75, value_parser = probability)]
    pub covered: f64,
}

crate::numbers::default_of_command_line!(Options);

/// EKF localisation by straight walls.
#[derive(Debug)]
pub struct Ekf {
    steps: Steps,
    counts: EncoderCounts,
    beams: Beams,
    extraction: Extraction,
    map: LineMap,
    gate: Gate,
    pose_in_world: SE2,
    covariance: Matrix3<f64>,
    /// The believed pose after the last scan.
    scanned_at: SE2,
    holding: Holding,
    monitor: Monitor,
    /// The constant errors of the wheels, once the innovations call for them.
    wheels: Option<WheelErrors>,
    watch: Option<Watch>,
}

impl Ekf {
    /// Begins at the pose that is told. Without a map it only predicts, and says
    /// so on stderr.
    ///
    /// # Errors
    /// [`ClientError::Unusable`] where no pose is told: this filter follows a
    /// robot, it does not begin without one. Or the walls of the map are invalid.
    pub fn new(start: &Start, options: &Options) -> Result<Self, ClientError> {
        let Some(pose_in_world) = start.initial_pose else {
            return Err(ClientError::Unusable(format!(
                "{:?} is not told where the robot starts, and an EKF cannot find it: give it \
                 initial_pose = \"given\" in the scenario, or take `mcl`",
                start.name
            )));
        };
        let map = start.map.as_ref().map(LineMap::new).unwrap_or_default();
        if map.lines.is_empty() {
            let name = &start.name;
            errln!(
                "{name}: there is no map with walls, so this is odometry with a growing covariance"
            );
        }
        let walls = &options.walls;
        let lidar = believed_lidar(start);
        let range_std_m = walls.range_std_m.unwrap_or(lidar.range_std_m);
        let watch = Watch::new(start, options.odometry, range_std_m.max(LEAST_MCL_STD_M))?;
        let extraction = Extraction {
            range_std_m: range_std_m.max(LEAST_RANGE_STD_M),
            min_points: walls.min_points as usize,
            min_length_m: walls.min_length_m,
        };
        Ok(Self {
            steps: Steps::new(start.robot.drive, options.odometry),
            counts: EncoderCounts::default(),
            beams: Beams::new(&lidar),
            extraction,
            map,
            gate: Gate::of_probability(walls.gate, walls.covered),
            pose_in_world,
            covariance: options.start.covariance(),
            scanned_at: pose_in_world,
            holding: Holding::default(),
            monitor: Monitor::default(),
            wheels: None,
            watch,
        })
    }

    /// Predicts: takes the encoder counts at the end of a tick (Table 7.2, lines
    /// 2 to 7).
    pub fn advance(&mut self, ticks: EncoderCounts) {
        let (step, of_step) = self.steps.advance(ticks);
        let mut motion = Motion::default();
        match &mut self.wheels {
            None => motion.push(&step, &(of_step * self.monitor.noise())),
            Some(wheels) => {
                let believed = wheels.believed(&step);
                let unknown = wheels.predict(&step);
                motion.push(&believed, &(of_step * self.monitor.noise() + unknown));
            }
        }
        (self.pose_in_world, self.covariance) =
            placed(&self.pose_in_world, &self.covariance, &motion);
        self.counts = ticks;
        if let Some(watch) = &mut self.watch {
            watch.advance(ticks);
        }
    }

    /// Corrects by the scan that was taken at the end of the tick (Table 7.3):
    /// how surprising its walls were, `None` if none was recognised.
    pub fn scan(&mut self, ranges_m: &[f64]) -> Option<Innovation> {
        if self.map.lines.is_empty() {
            return None;
        }
        self.hold(ranges_m);
        let segments = self.extraction.segments(&self.beams, ranges_m);
        let matches = self.matches(&segments);
        let mut sum = Innovation { nis: 0.0, degrees: 0 };
        for (segment, line) in matches {
            let innovation = line.innovation(segment, &self.pose_in_world, &self.covariance);
            let Some(updated) = updated(&self.pose_in_world, &self.covariance, &innovation) else {
                continue;
            };
            if let Some(wheels) = &mut self.wheels {
                wheels.correct(&innovation, &self.covariance);
            }
            (self.pose_in_world, self.covariance) = updated;
            sum.nis += innovation.nis();
            sum.degrees += 2;
        }
        self.test(sum);
        self.find_back(ranges_m);
        self.scanned_at = self.pose_in_world;
        (sum.degrees > 0).then_some(sum)
    }

    /// Predicts anew from the last scan, if this one says that something holds the robot.
    fn hold(&mut self, ranges_m: &[f64]) {
        let Some(watch) = &self.watch else { return };
        let (from, exactly) = (self.scanned_at, self.since_scan());
        let look = |poses: &_, odds| watch.look_at(&self.beams, ranges_m, poses, odds);
        if let Some(motion) = self.holding.ask(&from, &exactly, look) {
            self.pose_in_world = from.compose(&motion.now_in_then);
            self.covariance += motion.covariance;
        }
    }

    /// The believed way since the last scan; how unsure it is has been added to the pose.
    fn since_scan(&self) -> Motion {
        let now_in_then = self.scanned_at.inverse().compose(&self.pose_in_world);
        Motion { now_in_then, ..Motion::default() }
    }

    /// Tests the innovations. Where they are too large, the constant errors of the wheels
    /// enter the state, the next time the noise is raised, and the covariance is widened.
    fn test(&mut self, innovation: Innovation) {
        match self.monitor.take(innovation) {
            Verdict::Consistent => {}
            Verdict::TooSmall if self.monitor.noise() > 1.0 => self.monitor.lower(),
            Verdict::TooSmall => {}
            Verdict::TooLarge(by) => {
                self.covariance *= by.min(MOST_WIDENED);
                if self.wheels.is_none() {
                    self.wheels = Some(WheelErrors::unknown());
                    self.monitor.restart();
                } else {
                    self.monitor.raise();
                }
            }
        }
    }

    /// Takes the pose of the search, if the robot was lost and found.
    fn find_back(&mut self, ranges_m: &[f64]) {
        let Some(watch) = &mut self.watch else { return };
        let belief = (&self.pose_in_world, &self.covariance);
        let Some(found) = watch.scan(&self.beams, ranges_m, belief, self.counts) else { return };
        (self.pose_in_world, self.covariance) = found;
        self.monitor.restart();
        // It was lost with the errors that it had learned.
        self.wheels = Some(WheelErrors::unknown());
    }

    /// Whether the scans contradict the belief so much that it is not an answer.
    pub fn is_lost(&self) -> bool {
        self.watch.as_ref().is_some_and(|watch| watch.is_lost(&self.covariance))
    }

    /// Pieces of wall with the line of the map that each is, as far as that is
    /// certain.
    fn matches<'a>(&self, segments: &'a [Segment]) -> Vec<(&'a Segment, MapLine)> {
        let (pose, covariance) = (&self.pose_in_world, &self.covariance);
        let line = |s| self.map.match_of(s, pose, covariance, &self.gate).cloned();
        segments.iter().filter_map(|s| Some((s, line(s)?))).collect()
    }

    /// The believed pose of the body in the world frame.
    pub fn pose_in_world(&self) -> SE2 {
        self.belief().0
    }

    /// Covariance (m, m, rad) of the error τ: truth = [`pose_in_world`](Self::pose_in_world) ⊞ τ.
    pub fn covariance(&self) -> Matrix3<f64> {
        self.belief().1
    }

    /// Pose and covariance.
    fn belief(&self) -> (SE2, Matrix3<f64>) {
        match self.holding.until_next(|| self.since_scan()) {
            None => (self.pose_in_world, self.covariance),
            Some(motion) => {
                (self.scanned_at.compose(&motion.now_in_then), self.covariance + motion.covariance)
            }
        }
    }
}

impl Filter for Ekf {
    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        self.advance(tick.encoders());
        let innovation = tick.ranges_m().and_then(|ranges_m| self.scan(ranges_m));
        if self.is_lost() {
            return Reply::Abstain;
        }
        let (pose_in_world, covariance) = self.belief();
        Estimate { innovation, ..estimate(&pose_in_world, &covariance) }.into()
    }
}

/// Pose and covariance after an update, in Joseph's form; `None` where a number is
/// not finite.
pub fn updated(
    pose_in_world: &SE2,
    covariance: &Matrix3<f64>,
    innovation: &LineInnovation,
) -> Option<(SE2, Matrix3<f64>)> {
    let LineInnovation { nu, h, r, s } = innovation;
    let gain = covariance * h.transpose() * s.try_inverse()?;
    let tau = gain * nu;
    let rest = Matrix3::identity() - gain * h;
    let joseph = rest * covariance * rest.transpose() + gain * r * gain.transpose();
    // The same error, seen from the pose that τ leads to.
    let jr = right_jacobian(&tau);
    let covariance = symmetric(&(jr * joseph * jr.transpose()));
    let whole = tau.iter().chain(covariance.iter()).all(|v| v.is_finite());
    whole.then(|| (pose_in_world.boxplus(&tau), covariance))
}

#[cfg(test)]
#[path = "ekf_tests.rs"]
mod tests;
