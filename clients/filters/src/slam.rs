//! SLAM with a pose graph: where the robot is, and what the place looks like,
//! without a map.
//!
//! Sources: *Probabilistic Robotics*, ch. 11 (GraphSLAM); F. Lu and E. Milios,
//! *Globally consistent range scan alignment for environment mapping* (1997);
//! G. Grisetti et al., *A tutorial on graph-based SLAM* (2010). The front end is
//! [`crate::scan_match`], the back end [`crate::pose_graph`].
//!
//! Every key scan is a pose of the graph, tied to the one before by the motion
//! that wheels and matches say. A new one is matched with old ones near it, too:
//! these loops keep the map in one piece (`loops.rs`). A loop counts when
//! * the graph holds it possible that both scans look at the same walls,
//! * enough points of the new scan lie on the old one's walls,
//! * the match is no surprise to the graph (χ²), and
//! * it stays so next to all other motions: a match that does not loses weight.
//!
//! Where the graph is unsure of an old place, the new scan is first searched in a
//! [`Submap`](crate::submap::Submap) of the key scans there, in a window of five
//! deviations and at most 6 m and 46° to each side. Such a loop counts when no other pose
//! of the window fits as well and a second loop, of another new key scan, agrees with it.
//!
//! Departures: the answer of a tick is the newest key pose and the motion since
//! then; earlier answers stay as they were given. Points never move within their
//! scan; the grid that is saved is made of key scans, from where the graph has them
//! at the end. A scan takes part in several matches, whose errors are then related; a
//! loop counts for a share of its information accordingly (half). Where loops and chain
//! differ by more than they say, the covariance of an answer grows by as much.
//!
//! How much it holds: every key scan, whose ranges, rays and walls are some 170
//! bytes for each beam, and a pose and its motions, which are little compared with that. It
//! is the way that counts, not the time: with 180 beams and a key scan every 0.75 m,
//! 40 MB for each kilometre, even where the robot has been before.

use std::path::{Path, PathBuf};

use clap::Args;
use nalgebra::{Matrix3, Point2};
use rusty_clients::{ClientError, Filter, Tick};
use rusty_contract::{Estimate, Reply, Start, errln, replace, tum};
use rusty_geometry::{EncoderCounts, SE2};

use crate::gridmap::{self, Mapper, Poses};
use crate::icp::Surface;
use crate::moment::{Moment, RunClock};
use crate::motion::carried;
use crate::numbers::{positive, share};
use crate::occupancy_grid::InverseModel;
use crate::pose_graph::{Constraint, Kind, PoseGraph};
use crate::scan_match::{ScanMatchOptions, ScanOutcome, Tracker};
use crate::tangent::{estimate, placed, symmetric};

/// How loops are closed.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
#[command(next_help_heading = "Loop closing")]
pub struct LoopOptions {
    /// Maximum distance between the scans of a loop, m
    #[arg(long, value_name = "METRES", default_value_t = 2.5, value_parser = positive)]
    pub loop_distance_m: f64,

    /// Minimum number of key scans between those of a loop
    #[arg(long, value_name = "SCANS", default_value_t = 6)]
    pub loop_gap: usize,

    /// Maximum number of loops of a key scan, 0 for none
    #[arg(long, value_name = "LOOPS", default_value_t = 3)]
    pub loops: usize,

    /// Minimum share of matching points in a loop
    #[arg(long, value_name = "0..1", default_value_t = 0.65, value_parser = share)]
    pub loop_share: f64,
}

crate::numbers::default_of_command_line!(LoopOptions);

/// Localise and map with a pose graph, without a given map
///
/// Key scans are the nodes of the graph, and matches between them are its edges. When
/// the robot returns to a known place, the loop is closed and the whole path is
/// corrected (Probabilistic Robotics, chapter 11; Grisetti et al. 2010). The filter
/// learns the constant errors of the wheels and their noise. --alpha1 to --alpha4 are
/// lower limits of the noise. Unless the laser sees little, the variance of distances
/// begins with at least 0.001 m²/m. With --save-map the map is written at the end.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub struct SlamOptions {
    /// Save the map as STEM.pgm, STEM.yaml and STEM.png
    #[arg(long, value_name = "STEM")]
    pub save_map: Option<PathBuf>,

    /// Save the key poses of the final graph as a TUM trajectory
    #[arg(long, value_name = "FILE")]
    pub save_poses: Option<PathBuf>,

    /// End of the use of scans after the start of the run, s or ticks (12.5, 400ticks)
    #[arg(long, value_name = "MOMENT")]
    pub until: Option<Moment>,

    /// The front end.
    #[command(flatten)]
    pub front: ScanMatchOptions,

    /// What is believed of a reading, for the map.
    #[command(flatten)]
    pub model: InverseModel,

    /// The loops.
    #[command(flatten)]
    pub closing: LoopOptions,
}

/// A key scan as the graph keeps it.
#[derive(Clone, Debug)]
struct Seen {
    time_s: f64,
    ranges_m: Vec<f64>,
    surface: Surface,
}

/// SLAM with a pose graph.
#[derive(Debug)]
pub struct Slam {
    start: Start,
    options: SlamOptions,
    tracker: Tracker,
    graph: PoseGraph,
    seen: Vec<Seen>,
    /// Loops of a wide search that no other one has confirmed yet.
    unconfirmed: Vec<Constraint>,
    clock: RunClock,
    /// Time of the latest tick, s.
    now_s: f64,
    /// Covariance of the first key pose, where wheels alone led to it.
    of_first: Matrix3<f64>,
    /// Covariance of the newest key pose, world frame, where the motions are as sure as
    /// they say and the initial pose is certain.
    covariance: Matrix3<f64>,
    /// By how much the graph shows that they are not.
    variance_factor: f64,
}

impl Slam {
    /// Begins where it is told, or at the origin of a separate frame. What it is
    /// told of walls it does not look at.
    pub fn new(start: &Start, options: &SlamOptions) -> Self {
        Self {
            start: start.clone(),
            options: options.clone(),
            tracker: Tracker::new(start, &options.front),
            graph: PoseGraph::new(start.initial_pose.unwrap_or_default()),
            seen: Vec::new(),
            unconfirmed: Vec::new(),
            clock: RunClock::default(),
            now_s: 0.0,
            of_first: Matrix3::zeros(),
            covariance: Matrix3::zeros(),
            variance_factor: 1.0,
        }
    }

    /// Takes the counts at the end of a tick.
    pub fn advance(&mut self, ticks: EncoderCounts) {
        self.tracker.advance(ticks);
    }

    /// Takes a scan made at the end of the tick.
    pub fn scan(&mut self, ranges_m: &[f64]) -> ScanOutcome {
        let mut told = self.tracker.scan(ranges_m);
        let Some(key) = told.key.take() else { return told };
        let since_last = key.since_last;
        let is_first = self.seen.is_empty();
        self.seen.push(Seen {
            time_s: self.now_s,
            ranges_m: ranges_m.to_vec(),
            surface: key.surface,
        });
        if is_first {
            // The first scan that shows walls may come after some way by the wheels.
            self.graph = PoseGraph::new(self.graph.poses()[0] * since_last.now_in_then);
            (self.of_first, self.covariance) = (since_last.covariance, since_last.covariance);
            return told;
        }
        // Wheels that stood still are certain; information has to be finite.
        let floor = Matrix3::identity() * 1e-10;
        let information = (since_last.covariance + floor).try_inverse();
        let information = information.unwrap_or_else(Matrix3::identity);
        self.graph.extend(&since_last.now_in_then, &symmetric(&information));
        self.covariance = symmetric(&since_last.propagate(&self.covariance));
        let optimised = self.close_loops() && self.graph.optimise().is_some();
        if let Some(covariance) = self.graph.last_covariance().filter(|_| optimised) {
            let [first, .., newest] = self.graph.poses() else { return told };
            let way = first.inverse() * *newest;
            self.covariance = symmetric(&(carried(&self.of_first, &way) + covariance));
            self.variance_factor = self.graph.variance_factor();
        }
        told
    }

    /// Where the robot is, world frame, and the covariance of the error τ.
    pub fn pose(&self) -> (SE2, Matrix3<f64>) {
        let newest = self.graph.poses()[self.graph.poses().len() - 1];
        let mut covariance = self.covariance * self.variance_factor;
        if let Some(first) = self.start.initial_pose {
            let way = first.inverse() * newest;
            covariance += carried(&self.options.front.start_covariance(), &way);
        }
        placed(&newest, &covariance, self.tracker.since_key())
    }

    /// The poses and what was measured between them.
    pub fn graph(&self) -> &PoseGraph {
        &self.graph
    }

    /// The key poses as the graph has them now, world frame; none before the first scan
    /// that shows walls.
    pub fn key_poses(&self) -> &[SE2] {
        if self.seen.is_empty() { &[] } else { self.graph.poses() }
    }

    /// How many loops were closed.
    pub fn loops(&self) -> usize {
        self.graph.constraints().iter().filter(|c| c.kind == Kind::Loop).count()
    }

    /// The map: the pose of every key scan, and what it met there, world frame, m.
    pub fn map(&self) -> impl Iterator<Item = (SE2, Vec<Point2<f64>>)> + '_ {
        self.graph.poses().iter().zip(&self.seen).map(|(pose, seen)| {
            let rays = seen.surface.rays().iter();
            (*pose, rays.map(|ray| pose.transform_point(&ray.point)).collect())
        })
    }

    /// Whether a scan at the end of the tick that ends at `time_s` is taken in. The
    /// run began with the first tick that is asked for.
    pub fn takes_in(&mut self, time_s: f64) -> bool {
        self.now_s = time_s;
        let now = self.clock.tick(time_s, self.start.dt_s);
        self.options.until.is_none_or(|until| now.is_until(until))
    }

    /// Writes the key poses as the graph has them, with the times of their scans.
    ///
    /// # Errors
    /// There is no key scan, or the file cannot be written.
    fn write_poses(&self, file: &Path) -> Result<(), ClientError> {
        if self.seen.is_empty() {
            let text = "--save-poses: no scan became a key scan, so there is no pose to save";
            return Err(ClientError::Unusable(text.to_owned()));
        }
        let keys = self.graph.poses().iter().zip(&self.seen);
        let lines: String = keys.map(|(pose, key)| tum::line(key.time_s, pose) + "\n").collect();
        replace(file, lines.as_bytes()).map_err(ClientError::io(file))
    }

    /// Writes the map to `stem`, and says what is in it. Where a key scan does not
    /// fit, those before it are the map.
    ///
    /// # Errors
    /// A key scan that does not fit, no scan that showed walls, or a file that
    /// cannot be written.
    fn write_map(&self, stem: &Path) -> Result<String, ClientError> {
        let grid = gridmap::Options {
            poses: Poses::Odometry,
            save: stem.to_owned(),
            from: Moment::Ticks(0),
            until: None,
            model: self.options.model,
            noise: self.options.front.wheels,
        };
        let (mut mapper, count) = (Mapper::new(&self.start, &grid), self.seen.len());
        let keys = self.graph.poses().iter().zip(&self.seen);
        let refused = keys.enumerate().find_map(|(k, (pose, seen))| {
            let why = mapper.add(&seen.ranges_m, pose).err()?;
            let text = format!("--save-map: key scan {} of {count}: {why}", k + 1);
            Some(ClientError::Unusable(text))
        });
        let written = mapper.write()?;
        if let Some(refused) = refused {
            return Err(refused);
        }
        let nothing = || {
            let until =
                self.options.until.map(|until| format!(" until {until}")).unwrap_or_default();
            let text = format!("--save-map: no scan showed walls{until}, no map written");
            ClientError::Unusable(text)
        };
        written.ok_or_else(nothing)
    }
}

impl Filter for Slam {
    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        self.advance(tick.encoders());
        let is_wanted = self.takes_in(tick.time_s());
        let ranges_m = tick.ranges_m().filter(|_| is_wanted);
        let told = ranges_m.map(|ranges_m| self.scan(ranges_m)).unwrap_or_default();
        let (pose, covariance) = self.pose();
        Estimate { innovation: told.innovation, ..estimate(&pose, &covariance) }.into()
    }

    fn finish(self) -> Result<(), ClientError> {
        // A run that ended before it began is the failure of another process.
        if !self.clock.is_running() {
            return Ok(());
        }
        if let Some(file) = &self.options.save_poses {
            self.write_poses(file)?;
            errln!("{} key poses in {}", self.seen.len(), file.display());
        }
        let Some(stem) = &self.options.save_map else { return Ok(()) };
        let said = self.write_map(stem)?;
        errln!("{} loops; {said}", self.loops());
        Ok(())
    }
}

mod loops;
#[cfg(test)]
mod tests;
