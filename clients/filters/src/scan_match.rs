//! Scan matching as odometry: the wheels' motion, corrected by matching each
//! scan with a key scan.
//!
//! Source: A. Censi, *An ICP variant using a point-to-line metric*, ICRA 2008,
//! whose program `canonical_scan_matcher` keeps a key scan likewise; *Probabilistic
//! Robotics*, §5.4 for the wheels and §3.2 for putting both together.
//!
//! All scans since the key scan are matched with it, not with the one before:
//! errors add up from key scan to key scan only. Each match is one measurement
//! of the motion since the key scan, and the wheels since then are its prior
//! ([`crate::calibration`]: they learn their constant errors and their noise). Both are
//! independent, so what comes out is as sure as it says; the matches before it
//! have the noise of the key scan in common with it and are not used, except as
//! the place to begin. Where a match surprises the wheels beyond chance, they did
//! something that they do not do (a bump, a door sill, a scan that came late), and
//! it is matched again with a prior that allows for that, and where that does not fit
//! either, it is searched in a map of the newest key scans ([`crate::submap`]). Where another
//! pose fits nearly as well there, the motion is as unsure as half of the way between both.
//! A scan of few ends, or of a piece of one wall, is not searched: it fits in many places.
//! Beams that end short of what both neighbours see are left out where there are many.
//!
//! What it leaves out: one scan is the end of one motion and the beginning of
//! the next, so errors of neighbouring motions are related (mostly of opposite
//! sign). Taken as independent they add up to more than there is.

use clap::Args;
use nalgebra::Matrix3;
use rusty_clients::{Filter, Tick};
use rusty_contract::{Estimate, Innovation, Reply, Start};
use rusty_geometry::{EncoderCounts, SE2, trig};

use self::doubts::{lost, slipped};
use self::matched::Matched;
use crate::beams::believed_lidar;
use crate::calibration::LearningWheels;
use crate::icp::{Evidence, FEWEST, IcpOptions, Laser, NoMatch, Ray, Surface, without_lone};
use crate::numbers::{not_negative, positive, share};
use crate::submap::is_meagre;
use crate::tangent::{chained, estimate, independent, placed, symmetric};
use crate::{Motion, OdometryNoise};

/// Key scans of the submap that a scan is searched in.
const SUBMAP_SCANS: usize = 10;
/// Where little matches, or a scan had to be searched, a key scan follows after this part of
/// the way or turn: wheels that slipped may do so again.
const EARLY: f64 = 0.2;

/// Estimate odometry by scan matching
///
/// Each scan is matched to the walls of a key scan (point-to-line ICP). The encoders
/// give the initial guess and its uncertainty. No map is needed. The estimate drifts
/// only from key scan to key scan, and its covariance grows accordingly. The filter
/// learns the constant errors of the wheels and their noise. --alpha1 to --alpha4 are
/// lower limits of the noise. Unless the laser sees little, the variance of distances
/// begins with at least 0.001 m²/m.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
pub struct ScanMatchOptions {
    /// Distance between key scans, m
    #[arg(long, value_name = "METRES", default_value_t = 0.75, value_parser = positive)]
    pub key_distance_m: f64,

    /// Turn between key scans, degrees, at most half the view
    #[arg(long, value_name = "DEGREES", default_value_t = 40.0, value_parser = positive)]
    pub key_turn_deg: f64,

    /// Share of matching points below which a key scan follows
    #[arg(long, value_name = "0..1", default_value_t = 0.7, value_parser = share)]
    pub key_share: f64,

    /// Standard deviation of the initial pose, where it is given, each axis, m
    #[arg(long, value_name = "METRES", default_value_t = 0.0, value_parser = not_negative)]
    pub start_std_m: f64,

    /// The same of the initial heading, degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, value_parser = not_negative)]
    pub start_std_deg: f64,

    /// How scans are matched.
    #[command(flatten)]
    pub icp: IcpOptions,

    /// What is believed of the wheels.
    #[command(flatten)]
    pub wheels: OdometryNoise,
}

crate::numbers::default_of_command_line!(ScanMatchOptions);

impl ScanMatchOptions {
    /// The covariance of the error of the initial pose, m, m and rad.
    pub(crate) fn start_covariance(&self) -> Matrix3<f64> {
        independent(self.start_std_m, self.start_std_deg.to_radians())
    }
}

/// A scan that others are matched with.
#[derive(Clone, Debug)]
pub struct KeyScan {
    /// What it met, and the walls there.
    pub surface: Surface,
    /// The motion to it from the key scan before it; none for the first.
    pub since_last: Motion,
}

/// What a scan told.
#[derive(Clone, Debug, Default)]
pub struct ScanOutcome {
    /// How surprising it was, where it matched.
    pub innovation: Option<Innovation>,
    /// Why it did not.
    pub no_match: Option<NoMatch>,
    /// The new key scan, where it became one.
    pub key: Option<KeyScan>,
}

/// The motion since the last key scan.
#[derive(Clone, Debug)]
pub struct Tracker {
    options: ScanMatchOptions,
    laser: Laser,
    /// The turn between key scans, rad: at most half of the field of view.
    key_turn_rad: f64,
    wheels: LearningWheels,
    /// The walls of the key scan.
    surface: Option<Surface>,
    /// The newest key scans, the last one too, with their poses in its frame.
    recent: Vec<(SE2, Vec<Ray>)>,
    /// By wheels and matches, from the key scan to the last scan.
    to_scan: Motion,
    /// The same to now.
    to_now: Motion,
}

impl Tracker {
    /// Begins where the robot is, with counts of zero.
    pub fn new(start: &Start, options: &ScanMatchOptions) -> Self {
        let laser = Laser::new(&believed_lidar(start));
        // With a laser that sees little the pose depends on the wheels, and scans teach little
        // about them.
        let wheels = if laser.sees_little() {
            LearningWheels::new(start.robot.drive, options.wheels)
        } else {
            LearningWheels::with_unknown_noise(start.robot.drive, options.wheels)
        };
        Self {
            options: *options,
            key_turn_rad: options.key_turn_deg.to_radians().min(0.5 * laser.fov_rad()),
            laser,
            wheels,
            surface: None,
            recent: Vec::new(),
            to_scan: Motion::default(),
            to_now: Motion::default(),
        }
    }

    /// How it matches.
    pub fn laser(&self) -> &Laser {
        &self.laser
    }

    /// The motion from the last key scan to now.
    pub fn since_key(&self) -> &Motion {
        &self.to_now
    }

    /// Takes the counts at the end of a tick.
    pub fn advance(&mut self, ticks: EncoderCounts) {
        self.wheels.advance(ticks);
        self.to_now = chained(&self.to_scan, &self.wheels.since_scan());
    }

    /// Takes a scan made at the end of the tick.
    pub fn scan(&mut self, ranges_m: &[f64]) -> ScanOutcome {
        self.to_scan = chained(&self.to_scan, &self.wheels.since_scan());
        self.wheels.begin_scan();
        let rays = without_lone(&self.laser, self.laser.rays(ranges_m));
        let scan = Surface::new(&self.laser, &rays, self.options.icp.roughness_m);
        let mut told = ScanOutcome::default();
        let Some(surface) = &self.surface else {
            told.key = self.new_key(scan, None);
            return told;
        };
        let (mut share, mut evidence, mut is_searched) = (0.0, None, false);
        match self.matched(surface, &scan) {
            Ok(Matched { fused, found, searched }) => {
                share = found.share;
                evidence = Some(found.evidence);
                is_searched = searched;
                self.to_scan = fused.motion;
                told.innovation = Some(fused.innovation);
            }
            Err(why) => told.no_match = Some(why),
        }
        let is_lost = told.no_match.is_some();
        self.to_now = self.to_scan;
        let matches_well = share >= self.options.key_share;
        if self.is_beyond(1.0) || ((!matches_well || is_searched) && self.is_beyond(EARLY)) {
            let to_scan = self.to_scan;
            if is_lost {
                // A narrow view often shows what no key scan did; that refutes no wheels.
                let is_meagre = is_meagre(&self.laser, scan.rays());
                self.to_scan = if is_meagre { slipped(&to_scan) } else { lost(&to_scan) };
            }
            told.key = self.new_key(scan, evidence.filter(|_| matches_well));
            if told.key.is_none() {
                self.to_scan = to_scan;
            }
        }
        told
    }

    /// Whether it has come farther than this part of the way, or turned more than
    /// this part of the turn, after which a key scan follows.
    fn is_beyond(&self, part: f64) -> bool {
        let moved = &self.to_scan.now_in_then;
        trig::hypot(moved.x(), moved.y()) > part * self.options.key_distance_m
            || moved.theta().abs() > part * self.key_turn_rad
    }

    /// Makes a key scan of what was met, and learns from what the scan said of the
    /// motion to it; `None` where it shows too little for anything to be matched
    /// with it.
    fn new_key(&mut self, surface: Surface, evidence: Option<Evidence>) -> Option<KeyScan> {
        if surface.pieces().len() < FEWEST {
            return None;
        }
        if let Some(evidence) = evidence {
            self.wheels.learn(&evidence);
        }
        self.wheels.begin_key();
        let since_last = std::mem::take(&mut self.to_scan);
        self.to_now = Motion::default();
        let back = since_last.now_in_then.inverse();
        self.recent.iter_mut().for_each(|(pose, _)| *pose = back * *pose);
        let first = (self.recent.len() + 1).saturating_sub(SUBMAP_SCANS);
        self.recent.drain(..first);
        self.recent.push((SE2::identity(), surface.rays().to_vec()));
        self.surface = Some(surface.clone());
        Some(KeyScan { surface, since_last })
    }
}

/// Scan matching as odometry.
#[derive(Clone, Debug)]
pub struct ScanMatch {
    tracker: Tracker,
    key_in_world: SE2,
    covariance: Matrix3<f64>,
}

impl ScanMatch {
    /// Begins where it is told, or at the origin of a separate frame.
    pub fn new(start: &Start, options: &ScanMatchOptions) -> Self {
        Self {
            tracker: Tracker::new(start, options),
            key_in_world: start.initial_pose.unwrap_or_default(),
            // A separate frame begins exactly at its origin.
            covariance: match start.initial_pose {
                Some(_) => options.start_covariance(),
                None => Matrix3::zeros(),
            },
        }
    }

    /// Takes the counts at the end of a tick.
    pub fn advance(&mut self, ticks: EncoderCounts) {
        self.tracker.advance(ticks);
    }

    /// Takes a scan made at the end of the tick.
    pub fn scan(&mut self, ranges_m: &[f64]) -> ScanOutcome {
        let told = self.tracker.scan(ranges_m);
        if let Some(key) = &told.key {
            self.key_in_world = self.key_in_world * key.since_last.now_in_then;
            self.covariance = symmetric(&key.since_last.propagate(&self.covariance));
        }
        told
    }

    /// Where the robot is, world frame, and the covariance of the error τ.
    pub fn pose(&self) -> (SE2, Matrix3<f64>) {
        placed(&self.key_in_world, &self.covariance, self.tracker.since_key())
    }
}

impl Filter for ScanMatch {
    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        self.advance(tick.encoders());
        let told = tick.ranges_m().map(|ranges_m| self.scan(ranges_m)).unwrap_or_default();
        let (pose, covariance) = self.pose();
        Estimate { innovation: told.innovation, ..estimate(&pose, &covariance) }.into()
    }
}

mod doubts;
mod matched;
#[cfg(test)]
pub(crate) mod tests;
