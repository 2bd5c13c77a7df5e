//! The histogram filter in the Hallway: where along the corridor, and which way.
//!
//! Source: *Probabilistic Robotics*, §1.2, Fig. 1.1 (the robot that passes identical doors),
//! Tables 2.1 and 4.1. The belief is a histogram over cells along the corridor,
//! once for a robot that faces east and once for one that faces west; it begins
//! uniform, whatever initial pose is given. The measurement is "door" or "no
//! door" on either side ([`crate::corridor`]); the map says how likely each is in
//! each cell, and a stated error does the rest.
//!
//! Departures, and why:
//! * Cells move with the odometry as a whole; see [`crate::histogram`].
//! * A wall is looked at again only after some way. The same stretch looked at
//!   twice errs twice in the same way, and Bayes' rule takes it for two opinions.
//! * Across the corridor there is nothing to search: offset and heading come from
//!   the straight walls of the last scan, and from the odometry since. Two walls look
//!   the same either way round, so it is the odometry that says when the robot has
//!   turned about (the variance of the offset takes the heading's errors of two ticks
//!   for independent), and then all that was believed of one heading is believed of the
//!   other. Half-way round, what looks like a side is an end of the corridor.
//! * The answer is the mean of the peak with the most likely cell. Its covariance
//!   is that of the whole belief around it, other peaks and the other heading
//!   included: a filter that holds three doors possible must say so.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use clap::Args;
use nalgebra::{Matrix3, Vector2};
use rusty_clients::{ClientError, Filter, Tick};
use rusty_contract::{BeliefKind, Reply, Start, WeightedPose};
use rusty_geometry::{EncoderCounts, SE2, trig, wrap_angle};

use crate::beams::believed_lidar;
use crate::corridor::{Across, Corridor, Doors, Sides};
use crate::histogram::Histogram;
use crate::lines::Extraction;
use crate::numbers::number;
use crate::tangent::estimate;
use crate::{Beams, Odometry, OdometryNoise};

/// A wall is looked at again after this way, m.
const LOOK_EVERY_M: f64 = 0.1;
/// Walls within this, rad, of the direction in which the odometry expects them, or
/// of the opposite one, are the sides.
const SIDES_RAD: f64 = FRAC_PI_4;
/// A cell with less than this share of the mode's mass is beyond its peak.
const PEAK_SHARE: f64 = 0.05;

/// Localise in a corridor by its doors with a histogram filter
///
/// The filter (Probabilistic Robotics, chapters 2 and 4) is for a corridor along x
/// with recessed doors, the world "hallway". Its belief is over cells along the
/// corridor and over both headings, and is uniform at the start. It needs the map
/// and no initial pose. After one door the belief has a peak at each door; the
/// distance to the next door selects one.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// What is believed of the wheels.
    #[command(flatten)]
    pub odometry: OdometryNoise,

    /// Length of a cell, m
    #[arg(long, value_name = "METRES", default_value_t = 0.05, value_parser = length)]
    pub cell_m: f64,

    /// Probability that a look at a wall is wrong
    #[arg(long, value_name = "P", default_value_t = 0.05, value_parser = error)]
    pub look_error: f64,
}

crate::numbers::default_of_command_line!(Options);

fn length(text: &str) -> Result<f64, String> {
    number(text, |v| (0.001..=10.0).contains(&v), "a length from 0.001 to 10")
}

fn error(text: &str) -> Result<f64, String> {
    number(text, |v| v > 0.0 && v < 0.5, "a probability between 0 and 0.5")
}

/// The histogram filter.
#[derive(Clone, Debug)]
pub struct BayesHallway {
    odometry: Odometry,
    beams: Beams,
    extraction: Extraction,
    corridor: Corridor,
    look_error: f64,
    /// First the cells of a robot that faces east, then those of one that faces
    /// west, both from west to east.
    histogram: Histogram,
    /// Way ahead that no shift has made yet, m, and its variance, m².
    rest_m: f64,
    rest_variance: f64,
    /// Way since the walls were looked at, m.
    since_look_m: f64,
    across: Across,
}

impl BayesHallway {
    /// Begins anywhere in the corridor, facing either way.
    ///
    /// # Errors
    /// [`ClientError::Unusable`] without a map, or with one that is no corridor.
    pub fn new(start: &Start, options: &Options) -> Result<Self, ClientError> {
        let Some(plan) = &start.map else {
            return Err(ClientError::Unusable(format!(
                "{:?} is not told the map, and looks for its doors: give it map = \"given\" in \
                 the scenario",
                start.name
            )));
        };
        let corridor = Corridor::new(plan, options.cell_m)?;
        let lidar = believed_lidar(start);
        let extraction = Extraction {
            range_std_m: lidar.range_std_m.max(1e-4),
            min_points: 6,
            min_length_m: 0.4,
        };
        Ok(Self {
            odometry: Odometry::new(start.robot.drive, options.odometry),
            beams: Beams::new(&lidar),
            extraction,
            look_error: options.look_error,
            histogram: Histogram::new(vec![1.0; 2 * corridor.doors.len()]),
            rest_m: 0.0,
            rest_variance: 0.0,
            since_look_m: f64::INFINITY,
            across: Across::anywhere(corridor.width_m),
            corridor,
        })
    }

    /// Predicts: takes the encoder counts at the end of a tick.
    pub fn advance(&mut self, ticks: EncoderCounts) {
        self.odometry.advance(ticks);
        let motion = self.odometry.take();
        let way_m: Vector2<f64> = motion.now_in_then.translation();
        let [along_m, left_m] = self.across.along_and_left_m(way_m);
        self.rest_m += along_m;
        self.rest_variance += motion.covariance[(0, 0)];
        self.since_look_m += along_m.abs();
        let across = &mut self.across;
        across.left_m += left_m;
        across.left_variance +=
            motion.covariance[(1, 1)] + along_m * along_m * across.turned_variance;
        across.turned_rad += motion.now_in_then.theta();
        across.turned_variance += motion.covariance[(2, 2)];

        let (cells, cell_m) = (self.corridor.doors.len(), self.corridor.cell_m);
        let whole = (self.rest_m / cell_m).round();
        if whole != 0.0 {
            self.rest_m -= whole * cell_m;
            self.histogram.shift(0..cells, whole as i64);
            self.histogram.shift(cells..2 * cells, (whole as i64).saturating_neg());
        }
    }

    /// Corrects by the scan that was taken at the end of the tick.
    pub fn scan(&mut self, ranges_m: &[f64]) {
        let sides = Sides::of_scan(&self.extraction, &self.beams, ranges_m);
        if let Some(across) = Across::of_sides(&sides, self.corridor.width_m) {
            let off_rad = wrap_angle(across.turned_rad - self.across.turned_rad).abs();
            if off_rad.min(PI - off_rad) >= SIDES_RAD {
                return;
            }
            if off_rad > FRAC_PI_2 {
                self.turn_about();
            }
            self.across = across;
        }
        if self.since_look_m >= LOOK_EVERY_M {
            self.see(&sides.doors(&self.beams, ranges_m));
        }
    }

    /// Corrects by a look at the walls.
    pub fn see(&mut self, doors: &Doors) {
        let (cells, cell_m) = (self.corridor.doors.len(), self.corridor.cell_m);
        let variance = std::mem::take(&mut self.rest_variance) / (cell_m * cell_m);
        self.histogram.spread(0..cells, variance);
        self.histogram.spread(cells..2 * cells, variance);
        let (corridor, error) = (&self.corridor, self.look_error);
        self.histogram.correct(|k| corridor.likelihood(doors, k % cells, k < cells, error));
        if doors.left.is_some() || doors.right.is_some() {
            self.since_look_m = 0.0;
        }
    }

    /// What was believed of a robot that faces east is believed of one that faces
    /// west, and the other way round: it looks back along the corridor.
    fn turn_about(&mut self) {
        self.histogram.swap_halves();
        self.rest_m = -self.rest_m;
    }

    /// The belief: the cells of a robot that faces east, west to east, then those
    /// of one that faces west.
    pub fn histogram(&self) -> &Histogram {
        &self.histogram
    }

    /// The corridor that it is in.
    pub fn corridor(&self) -> &Corridor {
        &self.corridor
    }

    /// Pose of a cell of the histogram, world frame.
    fn pose_in_world(&self, x_m: f64, east: bool) -> SE2 {
        let (sign, heading_rad) = if east { (1.0, 0.0) } else { (-1.0, PI) };
        let y_m = self.corridor.middle_y_m + sign * self.across.left_m;
        SE2::new(x_m, y_m, heading_rad + self.across.turned_rad)
    }

    /// x of a cell with the way that no shift has made yet, m.
    fn x_m(&self, k: usize) -> f64 {
        let cells = self.corridor.doors.len();
        let sign = if k < cells { 1.0 } else { -1.0 };
        self.corridor.x_m(k % cells) + sign * self.rest_m
    }

    /// The mean of the likeliest peak, and the covariance of the whole belief
    /// around it (of τ, truth = pose ⊞ τ).
    pub fn estimate(&self) -> (SE2, Matrix3<f64>) {
        let (cells, belief) = (self.corridor.doors.len(), self.histogram.cells());
        let mode = self.histogram.mode();
        let east = mode < cells;
        let row = if east { 0..cells } else { cells..2 * cells };
        let counts = |k: &usize| belief[*k] >= PEAK_SHARE * belief[mode];
        let from = (row.start..mode).rev().take_while(counts).last().unwrap_or(mode);
        let to = (mode..row.end).take_while(counts).last().unwrap_or(mode);
        let mass: f64 = belief[from..=to].iter().sum();
        let x_m = (from..=to).map(|k| belief[k] * self.x_m(k)).sum::<f64>() / mass;

        let off_m2 = |k: usize| (self.x_m(k) - x_m) * (self.x_m(k) - x_m);
        let x_variance: f64 = (0..2 * cells).map(|k| belief[k] * off_m2(k)).sum();
        let other: f64 = belief.iter().sum::<f64>() - belief[row].iter().sum::<f64>();
        let across = &self.across;
        let mut c = Matrix3::zeros();
        let cell_m = self.corridor.cell_m;
        c[(0, 0)] = x_variance + self.rest_variance + cell_m * cell_m / 12.0;
        c[(1, 1)] = across.left_variance + other.max(0.0) * 4.0 * across.left_m * across.left_m;
        c[(2, 2)] = across.turned_variance + other.max(0.0) * PI * PI;
        // From the corridor's axes into the body's.
        let (s, k) = trig::sin_cos(across.turned_rad);
        let turn = Matrix3::new(k, s, 0.0, -s, k, 0.0, 0.0, 0.0, 1.0);
        let c = turn * c * turn.transpose();
        (self.pose_in_world(x_m, east), (c + c.transpose()) * 0.5)
    }
}

impl Filter for BayesHallway {
    const SHOWS_BELIEF: bool = true;

    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        self.advance(tick.encoders());
        if let Some(ranges_m) = tick.ranges_m() {
            self.scan(ranges_m);
        }
        let (pose, covariance) = self.estimate();
        estimate(&pose, &covariance).into()
    }

    fn belief(&self, poses: &mut Vec<WeightedPose>) -> Option<BeliefKind> {
        let cells = self.corridor.doors.len();
        poses.extend(self.histogram.cells().iter().enumerate().map(|(k, &weight)| {
            let pose = self.pose_in_world(self.x_m(k), k < cells);
            WeightedPose { x_m: pose.x(), y_m: pose.y(), theta_rad: pose.theta(), weight }
        }));
        Some(BeliefKind::Histogram)
    }
}

#[cfg(test)]
#[path = "bayes_hallway_tests.rs"]
mod tests;
