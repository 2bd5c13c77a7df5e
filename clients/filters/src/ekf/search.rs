//! Noticing that the scans do not fit the map any more, and finding back.
//!
//! The innovations of matched lines cannot show that a filter is lost: a gate lets only
//! small ones through. The ends of all beams can. The share of those that are near a wall
//! of the map, without those in front of it ([`hidden`]), has a fast and a slow mean, as the
//! likelihood in [`crate::mcl::recovery`]. When the fast one falls below the slow one, the robot
//! is searched for, and while it is far below, the filter abstains.
//!
//! The search is a cloud of particles ([`crate::mcl`]) around the belief, as wide as its
//! covariance says and a metre more; large errors of the wheels are expected more often than
//! by a normal law. Its likelihood fields go from coarse to fine, and it begins everywhere if it
//! fails. The pose that it finds must explain the beams better than the belief does over ten
//! scans. If it does not, half of the doubt goes.

use nalgebra::{Matrix3, Point2, Vector3};
use rusty_clients::ClientError;
use rusty_contract::Start;
use rusty_geometry::{EncoderCounts, SE2, World};

use crate::beams::Endpoint;
use crate::held::{MOVED, POSES};
use crate::mcl::recovery::{Recovery, hidden};
use crate::mcl::{self, Mcl, Prepared, is_somewhere};
use crate::{Beams, OdometryNoise};

/// An end of a beam is explained by a wall that is nearer than this, m.
const NEAR_M: f64 = 0.15;
/// σ of such a distance for a robot that is where it believes to be, m.
const NEAR_STD_M: f64 = 0.04;
/// At most this many beams of a scan are looked at for the doubt,
const FEW_BEAMS: usize = 60;
/// and for what holds the robot.
const MOST_BEAMS: usize = 90;
/// A search begins at this doubt, from 0 to 1,
const DOUBT: f64 = 0.15;
/// and no answer is given from this one on.
const LOST: f64 = 0.25;
/// Scans over which belief and search are compared.
const SCANS: u32 = 10;
/// Share of the beams by which a search must be better.
const BETTER: f64 = 0.05;
/// A search is this much wider than the belief, m and rad, one deviation.
const WIDER_M: f64 = 1.0;
const WIDER_RAD: f64 = 0.5;

/// The doubt, and the search for the robot while there is one.
#[derive(Debug)]
pub struct Watch {
    start: Start,
    options: mcl::Options,
    world: World,
    doubt: Recovery,
    search: Option<Box<Mcl>>,
    prepared: Option<Prepared>,
    /// Shares of belief and search, summed, and the number of scans.
    compared: (f64, f64, u32),
}

impl Watch {
    /// Begins without doubt; `None` without a map.
    ///
    /// # Errors
    /// [`ClientError::Unusable`]: the walls are invalid.
    pub fn new(
        start: &Start,
        noise: OdometryNoise,
        range_std_m: f64,
    ) -> Result<Option<Self>, ClientError> {
        let Some(map) = &start.map else { return Ok(None) };
        let world = World::new(map.clone()).map_err(|e| ClientError::Unusable(e.to_string()))?;
        let mut options = mcl::Options { noise, ..mcl::Options::default() };
        options.reading.sigma_m = Some(range_std_m);
        Ok(Some(Self {
            start: start.without_run(),
            options,
            world,
            doubt: Recovery::trusting(),
            search: None,
            prepared: None,
            compared: (0.0, 0.0, 0),
        }))
    }

    /// Whether the filter must abstain.
    pub fn is_lost(&self, covariance: &Matrix3<f64>) -> bool {
        self.doubt.share() > LOST || !is_somewhere(covariance)
    }

    /// Takes the counts at the end of a tick.
    pub fn advance(&mut self, counts: EncoderCounts) {
        if let Some(search) = &mut self.search {
            search.advance(0.0, counts);
        }
    }

    /// Takes the scan of the tick, after the belief was corrected by it. Returns pose and
    /// covariance where the robot was found elsewhere.
    pub fn scan(
        &mut self,
        beams: &Beams,
        ranges_m: &[f64],
        belief: (&SE2, &Matrix3<f64>),
        counts: EncoderCounts,
    ) -> Option<(SE2, Matrix3<f64>)> {
        let share = self.explained(beams, ranges_m, belief.0)?;
        self.doubt.update(share);
        let Some(search) = &mut self.search else {
            if self.doubt.share() > DOUBT || self.is_lost(belief.1) {
                self.begin(belief, counts);
            }
            return None;
        };
        search.scan(ranges_m);
        let Some(found) = search.answer() else {
            self.compared = (0.0, 0.0, 0);
            return None;
        };
        let covariance = Matrix3::from_row_slice(&found.covariance.unwrap_or_default());
        let of_search = self.explained(beams, ranges_m, &found.pose_in_world)?;
        let (of_belief, of_found, scans) = &mut self.compared;
        (*of_belief, *of_found, *scans) = (*of_belief + share, *of_found + of_search, *scans + 1);
        if *scans < SCANS {
            return None;
        }
        let is_better = *of_found > *of_belief + BETTER * f64::from(SCANS);
        self.compared = (0.0, 0.0, 0);
        self.search = None;
        if !is_better && is_somewhere(belief.1) {
            self.doubt.allay();
            return None;
        }
        self.doubt.found(of_search);
        Some((found.pose_in_world, covariance))
    }

    fn begin(&mut self, (pose, covariance): (&SE2, &Matrix3<f64>), counts: EncoderCounts) {
        let begun = Mcl::of_next_start(&self.start, &self.options, &mut self.prepared);
        // A map without a place for the robot has nothing to search.
        let Ok(mut search) = begun else { return };
        let wider = Vector3::new(WIDER_M, WIDER_M, WIDER_RAD);
        let wide = covariance + Matrix3::from_diagonal(&wider.component_mul(&wider));
        search.advance(0.0, counts);
        search.look_around(pose, &wide);
        self.search = Some(Box::new(search));
        self.compared = (0.0, 0.0, 0);
    }

    /// Share of the beams that end near a wall of the map, seen from `pose_in_world`, among those
    /// that can tell whether the robot is there. `None` where none met anything.
    fn explained(&self, beams: &Beams, ranges_m: &[f64], pose_in_world: &SE2) -> Option<f64> {
        let sensor_in_world = pose_in_world.compose(&beams.sensor_in_body);
        let sensor = Point2::from(sensor_in_world.translation());
        let (mut near, mut in_front, mut all) = (0.0, 0.0, 0.0);
        for end in some(beams, ranges_m, FEW_BEAMS) {
            all += 1.0;
            let point = pose_in_world.transform_point(&end.in_body);
            let direction = (point - sensor) / end.range_m;
            if self.world.distance_to_nearest(point) < NEAR_M {
                near += 1.0;
            } else if self.world.first_wall(sensor, direction, end.range_m).is_none() {
                in_front += 1.0;
            }
        }
        (all > 0.0).then(|| near / (all - hidden(in_front, all)))
    }

    /// ln p of a scan, but for a constant, at each of these poses, and of how many beams;
    /// `None` where none met anything, or where the scan fits where the wheels went so well
    /// that no other pose can be better by these odds (ln). An end farther than three deviations
    /// from all walls is on none of them.
    pub fn look_at(
        &self,
        beams: &Beams,
        ranges_m: &[f64],
        poses: &[SE2; POSES],
        odds: f64,
    ) -> Option<([f64; POSES], f64)> {
        let ends = || some(beams, ranges_m, MOST_BEAMS);
        let log = |pose: &SE2, end: Endpoint| {
            let distance_m = self.world.distance_to_nearest(pose.transform_point(&end.in_body));
            let deviations = (distance_m / NEAR_STD_M).min(3.0);
            -0.5 * deviations * deviations
        };
        let of = |pose| ends().map(|end| log(pose, end)).sum::<f64>();
        let (moved, all) = (of(&poses[MOVED]), ends().count() as f64);
        let log_of = |k| if k == MOVED { moved } else { of(&poses[k]) };
        (all > 0.0 && -moved >= odds).then(|| (std::array::from_fn(log_of), all))
    }
}

/// At most `most` of the laser's beams, of those the ones that met something.
fn some<'a>(
    beams: &'a Beams,
    ranges_m: &'a [f64],
    most: usize,
) -> impl Iterator<Item = Endpoint> + 'a {
    beams.every(beams.count().div_ceil(most).max(1), ranges_m)
}
