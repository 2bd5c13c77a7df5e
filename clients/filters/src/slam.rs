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
//! those loops are what keeps the map in one piece. A loop counts when
//! * the graph holds it possible that both scans look at the same walls,
//! * enough points of the new scan lie on the old one's walls,
//! * the match is no surprise to the graph (χ²), and
//! * it stays so next to all other motions: a match that does not loses weight.
//!
//! Departures: the answer of a tick is the newest key pose and the motion since
//! then; earlier answers stay as they were given. Points never move within their
//! scan; the grid that is saved is made of key scans, from where the graph has them
//! at the end. A scan takes part in several matches, whose errors are then related; a
//! loop counts for a share of its information accordingly (half).
//!
//! How much it holds: every key scan, whose ranges, rays and walls are some 170
//! bytes for each beam, and a pose and its motions, which are little compared with that. It
//! is the way that counts, not the time: with 180 beams and a key scan every 0.75 m,
//! 40 MB for each kilometre, even where the robot has been before.
//!
//! Where the graph is unsure of an old place, the match begins from a search that
//! ends 1.5 m and 0.48 rad from where the graph has it ([`match_widely`]): a robot
//! farther off than that closes no loop there.

use std::path::{Path, PathBuf};

use clap::Args;
use nalgebra::{Matrix3, Point2, Vector3};
use rusty_clients::{ClientError, Filter, Tick};
use rusty_contract::{Estimate, Reply, Start, errln};
use rusty_geometry::{EncoderCounts, SE2, trig};

use crate::Motion;
use crate::gridmap::{self, Mapper, Poses};
use crate::icp::{Surface, match_widely};
use crate::motion::carried;
use crate::numbers::{positive, seconds, share};
use crate::occupancy_grid::InverseModel;
use crate::pose_graph::{Constraint, Kind, PoseGraph};
use crate::scan_match::{ScanMatchOptions, ScanOutcome, Tracker};
use crate::tangent::{estimate, placed, symmetric};

/// A loop that surprises the graph more (χ² of three numbers) is none. That is far
/// beyond chance (16 once in a thousand), because motions through real rooms are
/// less certain than they say; what is doubtful then loses weight.
const LOOP_CHI2: f64 = 50.0;
/// What part of a loop's information counts: three loops and a chain share a scan.
const LOOP_SHARE: f64 = 0.5;
/// A search begins only where the graph is not this sure (m, rad).
const SURE_M: f64 = 0.15;
const SURE_RAD: f64 = 0.15;

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
/// corrected (Probabilistic Robotics, chapter 11; Grisetti et al. 2010). With
/// --save-map the map is written at the end.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub struct SlamOptions {
    /// Save the map as STEM.pgm, STEM.yaml and STEM.png
    #[arg(long, value_name = "STEM")]
    pub save_map: Option<PathBuf>,

    /// End of the use of scans after the start of the run, s
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub until: Option<f64>,

    /// What is believed of a reading, for that map.
    #[command(flatten)]
    pub model: InverseModel,

    /// The front end.
    #[command(flatten)]
    pub front: ScanMatchOptions,

    /// The loops.
    #[command(flatten)]
    pub closing: LoopOptions,
}

/// A key scan as the graph keeps it.
#[derive(Clone, Debug)]
struct Seen {
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
    /// When the first tick began, s.
    began_s: Option<f64>,
    /// Covariance of the first key pose, where wheels alone led to it.
    of_first: Matrix3<f64>,
    /// Covariance of the newest key pose, world frame.
    covariance: Matrix3<f64>,
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
            began_s: None,
            of_first: Matrix3::zeros(),
            covariance: Matrix3::zeros(),
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
        self.seen.push(Seen { ranges_m: ranges_m.to_vec(), surface: key.surface });
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
        }
        told
    }

    /// Matches the newest key scan with old ones near it. Whether there was any.
    fn close_loops(&mut self) -> bool {
        let candidates = self.candidates();
        if candidates.is_empty() {
            return false;
        }
        let newest = self.seen.len() - 1;
        let Some(expected) = self.graph.to_last(&candidates) else { return false };
        let mut closed = false;
        for (old, expected) in candidates.into_iter().zip(&expected) {
            if let Some((motion, information)) = self.matched(old, expected) {
                let information = information * LOOP_SHARE;
                let kind = Kind::Loop;
                self.graph.constrain(Constraint {
                    from: old,
                    to: newest,
                    motion,
                    information,
                    kind,
                });
                closed = true;
            }
        }
        closed
    }

    /// Old key scans that may have seen what the newest sees, the nearest first,
    /// no two of them neighbours.
    fn candidates(&self) -> Vec<usize> {
        let LoopOptions { loop_distance_m, loop_gap, loops, .. } = self.options.closing;
        let poses = self.graph.poses();
        let newest = poses.len() - 1;
        let unsure_m = 2.0 * (self.covariance[(0, 0)] + self.covariance[(1, 1)]).sqrt();
        let mut near: Vec<(f64, usize)> = (0..newest.saturating_sub(loop_gap))
            .map(|k| {
                let apart = poses[k].inverse() * poses[newest];
                let distance_m = trig::hypot(apart.x(), apart.y());
                // Half a metre is worth a sixth of a turn: scans that look elsewhere
                // have little in common.
                (distance_m + 0.5 * apart.theta().abs(), distance_m, k)
            })
            .filter(|(_, distance_m, _)| *distance_m < loop_distance_m + unsure_m)
            .map(|(cost, _, k)| (cost, k))
            .collect();
        near.sort_by(|(a, i), (b, j)| a.total_cmp(b).then(i.cmp(j)));
        let mut chosen: Vec<usize> = Vec::new();
        for (_, k) in near {
            if chosen.len() < loops && chosen.iter().all(|other| other.abs_diff(k) > 2) {
                chosen.push(k);
            }
        }
        chosen
    }

    /// The motion from an old key scan to the newest, if they match and the graph
    /// holds it possible.
    fn matched(&self, old: usize, expected: &Motion) -> Option<(SE2, Matrix3<f64>)> {
        let rays = self.seen.last()?.surface.rays();
        let deviation = |k: usize| expected.covariance[(k, k)].max(0.0).sqrt();
        let room = |deviation: f64, sure: f64| if deviation < sure { 0.0 } else { 2.0 * deviation };
        let apart_m = deviation(0).max(deviation(1));
        let half = Vector3::new(
            room(apart_m, SURE_M),
            room(apart_m, SURE_M),
            room(deviation(2), SURE_RAD),
        );
        let icp = &self.options.front.icp;
        let (surface, laser) = (&self.seen[old].surface, self.tracker.laser());
        let found = match_widely(surface, laser, rays, expected, &half, icp).ok()?;
        let surprise = found.evidence.fuse(expected)?.innovation.nis;
        let overlaps = found.pairs * 3 > rays.len();
        if surprise > LOOP_CHI2 || found.share < self.options.closing.loop_share || !overlaps {
            return None;
        }
        found.evidence.constraint()
    }

    /// Where the robot is, world frame, and the covariance of the error τ.
    pub fn pose(&self) -> (SE2, Matrix3<f64>) {
        let newest = self.graph.poses()[self.graph.poses().len() - 1];
        placed(&newest, &self.covariance, self.tracker.since_key())
    }

    /// The poses and what was measured between them.
    pub fn graph(&self) -> &PoseGraph {
        &self.graph
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
        let since_s = time_s - *self.began_s.get_or_insert(time_s - self.start.dt_s);
        self.options.until.is_none_or(|until| since_s <= until)
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
            from: 0.0,
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
            let until = self.options.until.map(|s| format!(" until {s} s")).unwrap_or_default();
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
        let stem = self.options.save_map.as_ref().filter(|_| self.began_s.is_some());
        let Some(stem) = stem else { return Ok(()) };
        let said = self.write_map(stem)?;
        errln!("{} loops; {said}", self.loops());
        Ok(())
    }
}

#[cfg(test)]
mod tests;
