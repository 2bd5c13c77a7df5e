//! Grid localisation: a histogram over x, y and heading in a known map.
//!
//! Source: *Probabilistic Robotics*, §8.2, Table 8.1 (Grid_localization), with the
//! remedies of §8.2.3: the sensor model is a precomputed likelihood field (§6.4), cells
//! with hardly any mass are left out (selective updating), and a scan is used only after
//! the robot has moved by half a cell or turned by half a heading (delayed motion
//! updates). For a uniform belief a scan is looked up for every free cell and heading.
//!
//! Departures, and why:
//! * Cells move with the robot; see the module `cells`. The error of a motion is a kernel of
//!   three cells in x, in y and in heading with the right variances. The correlation of
//!   heading and position comes from the headings, which move separately.
//! * The field has a σ of at least one cell. A scan has the weight of four independent
//!   beams, as in [`crate::mcl::sensor`]: a wrong centre of a cell moves the ends of all
//!   beams together. The two make a likelihood half a cell wide. A sharper one depends on
//!   the distance from the robot to the nearest centre, and decides by it between two rooms
//!   that look the same.
//! * Each motion spreads the masses by another 0.25 cells². The error of a centre is
//!   the same in successive scans, and without spread they would count as independent.
//! * Between modes small differences of the likelihood do not count; see the module `rivals`.
//! * While the scans are less likely than before, a small share of the belief is uniform, as
//!   in augmented MCL (Table 8.3, [`Recovery`]). At the start the scans have to become as
//!   likely as the model expects.
//! * The answer is the mean and the covariance of the heaviest mode, with the variance
//!   within a cell. It abstains while a second mode has more than a twentieth.
//!
//! A cell and heading needs about 40 bytes, and one look-up of 60 beams for each scan while
//! the belief is uniform: `docs/filters.md` has time and memory.

mod cells;
mod layer;
mod rivals;

use clap::Args;
use nalgebra::{Matrix3, Vector3};
use rusty_clients::{ClientError, Filter, Tick};
use rusty_contract::{BeliefKind, Estimate, Reply, Start, WeightedPose};
use rusty_geometry::{EncoderCounts, SE2, World};

use self::cells::Cells;
use crate::beams::believed_lidar;
use crate::kld::Bins;
use crate::likelihood_field::Ends;
use crate::mcl::mode::{Modes, SIDE_M, TURNS};
use crate::mcl::recovery::Recovery;
use crate::mcl::{Mode, Particles, Reading, is_somewhere};
use crate::numbers::number;
use crate::tangent::{estimate, placed};
use crate::{Beams, LikelihoodField, Odometry, OdometryNoise};

/// An initial pose is believed to be right up to this, m
const INITIAL_M: f64 = 0.05;
/// and this, rad.
const INITIAL_RAD: f64 = 0.05;
/// Most beams that are looked up.
const MOST_BEAMS: usize = 60;
/// Number of independent beams that a scan is worth.
const BEAMS_WORTH: f64 = 4.0;
/// Side of a cell of the field, of its blur.
const FIELD: f64 = 0.125;
/// Distance at which a wrong heading moves the end of a beam, m.
const LEVER_M: f64 = 2.0;
/// Variance that a motion adds to that of its error, cells².
const SPREAD: f64 = 0.25;
/// The largest share of the uniform law.
const UNIFORM: f64 = 0.01;
/// From this doubt on, the uniform law is mixed in.
const LOST: f64 = 0.3;
/// The largest share of the belief that a second mode has during an answer.
const RIVAL: f64 = 0.05;
/// Most cells, with all headings.
const MOST_CELLS: usize = 1 << 24;

/// Localise in a known map with a grid over x, y and heading
///
/// The filter (Probabilistic Robotics, section 8.2) has a probability for every cell and
/// heading. Odometry moves the cells, and a likelihood field weighs them. Without an
/// initial pose all free cells are equally likely. The filter abstains until most of the
/// belief is at one place.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Grid localisation")]
pub struct Options {
    /// Side of a cell, m
    #[arg(long, value_name = "METRES", default_value_t = 0.15, value_parser = side)]
    pub cell_m: f64,

    /// Angle between two headings, degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 5.0, value_parser = turn)]
    pub turn_deg: f64,

    /// Start anywhere, even if an initial pose is given
    #[arg(long)]
    pub global: bool,

    /// What is believed of a reading.
    #[command(flatten)]
    pub reading: Reading,

    /// What is believed of the wheels.
    #[command(flatten)]
    pub noise: OdometryNoise,
}

crate::numbers::default_of_command_line!(Options);

fn side(text: &str) -> Result<f64, String> {
    number(text, |v| (0.01..=2.0).contains(&v), "a length from 0.01 to 2")
}

fn turn(text: &str) -> Result<f64, String> {
    number(text, |v| (0.5..=45.0).contains(&v), "an angle from 0.5 to 45")
}

/// Grid localisation.
#[derive(Clone, Debug)]
pub struct GridLocalisation {
    odometry: Odometry,
    beams: Beams,
    field: LikelihoodField,
    ends: Ends,
    cells: Cells,
    recovery: Recovery,
    modes: Modes,
    bins: Bins,
    /// Cells that may be in a mode.
    likely: Particles,
    /// Heaviest mode after the last scan that was used, if that is an answer.
    answer: Option<Mode>,
    /// Whether a scan was used.
    has_begun: bool,
}

impl GridLocalisation {
    /// Begins at the initial pose, or anywhere.
    ///
    /// # Errors
    /// [`ClientError::Unusable`]: the map is missing, invalid, without a place for the
    /// robot, or has too many cells.
    pub fn new(start: &Start, options: &Options) -> Result<Self, ClientError> {
        let unusable = |text: String| Err(ClientError::Unusable(text));
        let Some(plan) = &start.map else {
            return unusable(format!(
                "{:?} has no map to localise in: give it map = \"given\" in the scenario",
                start.name
            ));
        };
        let world = World::new(plan.clone()).map_err(|e| ClientError::Unusable(e.to_string()))?;
        let (cell_m, headings) = (options.cell_m, (360.0 / options.turn_deg).round() as usize);
        let count = Cells::count(&world, cell_m, headings);
        if count > MOST_CELLS {
            return unusable(format!(
                "the map has {count} cells with all headings, and the limit is {MOST_CELLS}: \
                 give a larger --cell-m than {cell_m} or a larger --turn-deg than {}",
                options.turn_deg
            ));
        }
        let body_radius_m = start.robot.body_radius_m;
        let cells = Cells::of_world(&world, cell_m, headings, body_radius_m);
        let initial = start.initial_pose.filter(|_| !options.global);
        if cells.free_count() == 0 {
            return unusable(format!(
                "the map has no cell of {cell_m} m in which a body of {body_radius_m} m radius \
                 touches nothing: give a valid map or a smaller --cell-m"
            ));
        }
        let lidar = believed_lidar(start);
        let (model, beams) = (options.reading.model(&lidar)?, Beams::new(&lidar));
        let turned_m2 = LEVER_M * LEVER_M * cells.within_cell().z;
        let blur_m = (cell_m * cell_m + turned_m2).sqrt();
        let range_max_m = beams.range_max_m;
        let field = LikelihoodField::of_world(&world, &model, range_max_m, blur_m, FIELD * blur_m);
        // Bins of cells next to each other touch.
        let bins = Bins::new(cell_m.max(SIDE_M), (headings as u32).min(TURNS));
        Ok(Self {
            odometry: Odometry::new(start.robot.drive, options.noise),
            beams,
            field,
            ends: Ends::default(),
            cells,
            recovery: Recovery::trusting(),
            modes: Modes::of_bins(bins.clone()),
            bins,
            likely: Particles::default(),
            answer: None,
            has_begun: false,
        }
        .begin(initial))
    }

    fn begin(mut self, initial: Option<SE2>) -> Self {
        if let Some(pose_in_world) = initial {
            self.cells.fill_around(&pose_in_world, INITIAL_M, INITIAL_RAD);
            let [m2, rad2] = [INITIAL_M * INITIAL_M, INITIAL_RAD * INITIAL_RAD];
            let covariance = Matrix3::from_diagonal(&Vector3::new(m2, m2, rad2));
            self.answer = Some(Mode { pose_in_world, covariance, share: 1.0, second_share: 0.0 });
        } else {
            self.cells.mix(1.0);
            self.recovery = Recovery::lost(rusty_geometry::trig::exp(self.field.expected_log()));
        }
        self
    }

    /// Takes the encoder counts at the end of a tick.
    pub fn advance(&mut self, counts: EncoderCounts) {
        self.odometry.advance(counts);
    }

    /// Takes a scan at the end of the tick. It is used after a motion, or if it is the first.
    pub fn scan(&mut self, ranges_m: &[f64]) {
        if self.has_begun && !self.has_moved() {
            return;
        }
        let stride = self.beams.endpoints(ranges_m).count().div_ceil(MOST_BEAMS).max(1);
        let hits = self.beams.endpoints(ranges_m).step_by(stride);
        self.ends.set(hits.map(|end| end.in_body));
        if self.ends.count() == 0 {
            return;
        }
        self.has_begun = true;
        let motion = self.odometry.take();
        self.cells.move_by(&motion, SPREAD);
        let doubt = self.recovery.share();
        if doubt > LOST {
            self.cells.mix(UNIFORM * doubt);
        }
        let exponent = (BEAMS_WORTH / self.ends.count() as f64).min(1.0);
        let likelihood = self.cells.correct(&self.field, &self.ends, exponent);
        self.recovery.update(likelihood);
        self.cells.write_likely(&mut self.likely);
        rivals::level(&mut self.cells, &mut self.likely, &mut self.bins);
        let trusted = 1.0 - self.recovery.share();
        let within = Matrix3::from_diagonal(&self.cells.within_cell());
        let wider = |mode: Mode| Mode { covariance: mode.covariance + within, ..mode };
        let known = |mode: &Mode| {
            let is_likely = mode.share * trusted >= 0.5 && mode.second_share <= RIVAL;
            is_likely && is_somewhere(&mode.covariance)
        };
        self.answer = self.modes.heaviest(&self.likely).map(wider).filter(known);
    }

    /// Whether the robot has moved by half a cell or turned by half a heading since the
    /// last scan that was used.
    fn has_moved(&self) -> bool {
        let since = self.odometry.so_far().now_in_then;
        since.translation().norm() >= 0.5 * self.cells.cell_m()
            || since.theta().abs() >= 0.5 * self.cells.turn_rad()
    }

    /// The believed pose and its covariance, carried on by the wheels since the last scan
    /// that was used. `None` while the belief is spread.
    pub fn answer(&self) -> Option<Estimate> {
        let mode = self.answer.as_ref()?;
        let motion = self.odometry.so_far();
        let (pose, covariance) = placed(&mode.pose_in_world, &mode.covariance, motion);
        Some(estimate(&pose, &covariance))
    }
}

impl Filter for GridLocalisation {
    const SHOWS_BELIEF: bool = true;

    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        self.advance(tick.encoders());
        if let Some(ranges_m) = tick.ranges_m() {
            self.scan(ranges_m);
        }
        self.answer().map_or(Reply::Abstain, Reply::Estimate)
    }

    fn belief(&self, poses: &mut Vec<WeightedPose>) -> Option<BeliefKind> {
        let since = self.odometry.so_far().now_in_then;
        poses.extend(self.likely.poses().zip(&self.likely.weights).map(|(pose, &weight)| {
            let now = pose.compose(&since);
            WeightedPose { x_m: now.x(), y_m: now.y(), theta_rad: now.theta(), weight }
        }));
        Some(BeliefKind::Histogram)
    }
}

#[cfg(test)]
mod tests;
