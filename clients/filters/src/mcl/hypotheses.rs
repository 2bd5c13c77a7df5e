//! Places where the robot can be, each with how well the scans of several places fit.
//!
//! Source: P. Jensfelt, S. Kristensen, *Active global localization for a mobile robot using
//! multiple hypothesis tracking*, IEEE Transactions on Robotics and Automation 17(5), 2001:
//! hypotheses move with the robot, measurements confirm some of them and begin others, and
//! the robot is found when one has nearly all of the probability.
//!
//! Departures, and why:
//! * A measurement is the list of all poses of the map where a scan fits
//!   ([`super::everywhere`]), not a door or a corner.
//! * Where the particles are is a hypothesis as well, on the map or not: a robot in a room that
//!   is not on the map is not taken to the place of the map that is most like it.
//! * A corridor that is not on the map is like others that are, and in the long run one of them
//!   is likelier than all other places. But one scan of three fits another place better than
//!   that one; at the right place, no scan does. So the last scans decide too, except where the
//!   wheels took a robot that had left the map.
//! * Scans of one place err alike, so that one scan of each place counts; and it is worth at
//!   most [`BEAMS_WORTH`] beams and a factor of 20. What is not on the map is in all
//!   scans of a room, and a hypothesis survives it.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};
use rusty_geometry::SE2;

use super::Mode;
use super::everywhere::{Fits, is_near, is_within};
use super::sensor::BEAMS_WORTH;
use crate::Motion;

/// A scan is of a new place after this way, m, or turn, rad. Where a laser sees all round, the
/// scan after a turn on the spot, m, is of the same place.
const PLACE_M: f64 = 0.6;
const PLACE_RAD: f64 = 0.6;
const SPOT_M: f64 = 0.15;
/// What a scan costs a hypothesis at most, in ln p: it is 20 times less likely.
const MOST_COST: f64 = 3.0;
/// No hypothesis is less likely than the first by more than this, in ln p.
const DEEPEST: f64 = 15.0;
/// One that is found is more likely than all others by this, in ln p,
const MARGIN: f64 = 8.0;
/// one that is answered by this,
const LIKELY: f64 = 3.0;
/// and no other place fits any of this many last scans better than one that is found.
const SCANS: u32 = 5;
/// Where the wheels took a robot that was found before, this many scans have to fit,
const SCANS_HERE: u32 = 4;
/// and this is where they took it, m and rad.
const HERE_M: f64 = 3.0;
const HERE_RAD: f64 = 0.5;
/// The most hypotheses.
const MOST: usize = 256;
/// How near to the robot (m, rad) the pose of a hypothesis is, one deviation.
const NEAR_M: f64 = 0.15;
const NEAR_RAD: f64 = 0.1;

/// A place.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Hypothesis {
    pose_in_world: SE2,
    /// ln of how likely it is, less that of the first.
    log: f64,
    /// Number of scans that fitted since one that did not, and of those since one that fitted
    /// another place better.
    since: u32,
    best: u32,
}

impl Hypothesis {
    fn is_at(&self, pose_in_world: &SE2) -> bool {
        is_near(&self.pose_in_world, pose_in_world)
    }
}

/// All of them, the likeliest first.
#[derive(Clone, Debug, Default)]
pub(super) struct Hypotheses {
    all: Vec<Hypothesis>,
    /// Whether the laser sees all round.
    sees_all: bool,
    /// Way since the last scan that counted, and the number of those.
    since: SE2,
    scans: u32,
    /// Whether the robot was found before these scans.
    was_found: bool,
}

/// How far the robot may be from a hypothesis: covariance (m, m, rad).
pub(super) fn covariance() -> Matrix3<f64> {
    let deviations = Vector3::new(NEAR_M, NEAR_M, NEAR_RAD);
    Matrix3::from_diagonal(&deviations.component_mul(&deviations))
}

impl Hypotheses {
    /// Begins with none, for a laser with this field of view, rad.
    pub fn of_view(fov_rad: f64) -> Self {
        Self { sees_all: TAU - fov_rad < PLACE_RAD, ..Self::default() }
    }

    /// Forgets all, for a robot that is found or was.
    pub fn clear(&mut self) {
        *self = Self { was_found: true, sees_all: self.sees_all, ..Self::default() };
    }

    /// Moves all with the robot.
    pub fn move_by(&mut self, motion: &Motion) {
        self.since = self.since.compose(&motion.now_in_then);
        for one in &mut self.all {
            one.pose_in_world = one.pose_in_world.compose(&motion.now_in_then);
        }
    }

    /// Whether a scan counts: the first one, and those of other places.
    pub fn is_new_place(&self) -> bool {
        let way_m = self.since.translation().norm();
        let shows_more = !self.sees_all || way_m >= SPOT_M;
        let is_turned = shows_more && self.since.theta().abs() >= PLACE_RAD;
        self.scans == 0 || way_m >= PLACE_M || is_turned
    }

    /// Takes the places where a scan fits.
    pub fn take(&mut self, fits: &Fits) {
        let Some(best) = fits.places.first() else { return };
        (self.since, self.scans) = (SE2::identity(), self.scans + 1);
        let cost = |log: f64| (BEAMS_WORTH * (best.mean_log - log)).min(MOST_COST);
        let lowest = self.all.iter().map(|one| one.log).fold(0.0, f64::min);
        let mut is_taken = vec![false; fits.places.len()];
        let best_since = |before: u32, log: f64| if log >= best.mean_log { before + 1 } else { 0 };
        for one in &mut self.all {
            let mut free = (0..fits.places.len()).filter(|k| !is_taken[*k]);
            if let Some(k) = free.find(|k| one.is_at(&fits.places[*k].pose_in_world)) {
                is_taken[k] = true;
                one.pose_in_world = fits.places[k].pose_in_world;
                one.log -= cost(fits.places[k].mean_log);
                one.since += 1;
                one.best = best_since(one.best, fits.places[k].mean_log);
            } else {
                one.log -= cost(fits.others_log);
                (one.since, one.best) = (0, 0);
            }
        }
        for (fit, _) in fits.places.iter().zip(&is_taken).filter(|(_, is_taken)| !**is_taken) {
            let log = lowest - cost(fit.mean_log);
            let pose_in_world = fit.pose_in_world;
            let best = best_since(0, fit.mean_log);
            self.all.push(Hypothesis { pose_in_world, log, since: 1, best });
        }
        let first = self.all.iter().map(|one| one.log).fold(f64::NEG_INFINITY, f64::max);
        for one in &mut self.all {
            one.log = (one.log - first).max(-DEEPEST);
        }
        self.all.retain(|one| one.since > 0 || one.log > -DEEPEST);
        // The sort is stable: of equal ones the older.
        self.all.sort_by(|a, b| b.log.total_cmp(&a.log));
        self.all.truncate(MOST);
    }

    /// How much less likely (ln p) the second place is than the first.
    fn margin(&self) -> f64 {
        let Some(first) = self.all.first() else { return 0.0 };
        let mut others = self.all[1..].iter().filter(|one| !one.is_at(&first.pose_in_world));
        others.next().map_or(f64::INFINITY, |second| first.log - second.log)
    }

    /// Whether a mode of the belief may be the place where the robot is. Scans of two places
    /// can tell; the scan of one can only tell whether places look alike. Of a robot that left
    /// the map it takes as much as to find it: places that are not on the map are like others.
    pub fn agree(&self, mode: &Mode) -> bool {
        let is_likely = |first: &Hypothesis| mode.is_at(&first.pose_in_world);
        let is_it = self.scans < 2 || self.all.first().is_some_and(is_likely);
        is_it && self.margin() >= if self.was_found { MARGIN } else { LIKELY }
    }

    /// Whether scans of two places tell that the robot is elsewhere than a mode of the belief.
    pub fn deny(&self, mode: &Mode) -> bool {
        let mut near = self.all.iter().filter(|one| mode.is_at(&one.pose_in_world));
        self.scans >= 2 && near.all(|one| one.log <= -LIKELY)
    }

    /// The place where the robot is, if it can be in no other. `here` is where the wheels took
    /// it since it was found.
    pub fn decided(&self, here: Option<SE2>) -> Option<SE2> {
        let first = self.all.first()?;
        let is_here = here
            .filter(|_| self.was_found)
            .is_some_and(|here| is_within(&here, &first.pose_in_world, HERE_M, HERE_RAD));
        let is_known = if is_here { first.since >= SCANS_HERE } else { first.best >= SCANS };
        (is_known && self.margin() >= MARGIN).then_some(first.pose_in_world)
    }
}

#[cfg(test)]
mod tests {
    use super::super::everywhere::Fit;
    use super::*;

    /// Fits at these distances to the east, m, with ln p of a beam there.
    fn fits(places: &[(f64, f64)], others_log: f64) -> Fits {
        let fit = |&(x_m, mean_log): &(f64, f64)| Fit {
            pose_in_world: SE2::new(x_m, 0.0, 0.0),
            mean_log,
        };
        Fits { places: places.iter().map(fit).collect(), others_log }
    }

    /// Takes scans a metre apart: those fits moved by as many metres.
    fn drive(hypotheses: &mut Hypotheses, scans: &[&[(f64, f64)]], others_log: f64) {
        let metre = Motion { now_in_then: SE2::new(1.0, 0.0, 0.0), ..Motion::default() };
        for (way_m, places) in (1..).zip(scans) {
            hypotheses.move_by(&metre);
            assert!(hypotheses.is_new_place());
            let here: Vec<(f64, f64)> =
                places.iter().map(|(x_m, log)| (x_m + f64::from(way_m), *log)).collect();
            hypotheses.take(&fits(&here, others_log));
            assert!(!hypotheses.is_new_place());
        }
    }

    #[test]
    fn the_place_where_all_scans_fit_is_found_though_it_fitted_the_first_one_worse() {
        let mut hypotheses = Hypotheses::default();
        let scans: [&[(f64, f64)]; 5] = [
            &[(50.0, 0.4), (20.0, 0.3), (0.0, 0.1)],
            &[(80.0, 0.5), (0.0, 0.3)],
            &[(0.0, 0.4), (50.0, 0.3)],
            &[(0.0, 0.4)],
            &[(0.1, 0.3), (20.0, 0.2)],
        ];
        drive(&mut hypotheses, &scans[..4], -0.4);
        assert_eq!(hypotheses.all[0].pose_in_world.x(), 4.0);
        assert!((hypotheses.margin() - 2.8).abs() < 1e-9);
        assert_eq!(hypotheses.decided(None), None, "after four scans");
        let mut hypotheses = Hypotheses::default();
        drive(&mut hypotheses, &scans, -0.4);
        // By hand: 0.3 · 8 and 0.2 · 8 for the first two scans of the one, and 0, 3, 0.8, 3
        // and 3 for the other.
        let (first, second) = (hypotheses.all[0], hypotheses.all[1]);
        assert!((first.pose_in_world.x() - 5.1).abs() < 1e-12, "{first:?}");
        assert!((second.log + 9.8 - 4.0).abs() < 1e-9, "{second:?}");
        assert_eq!(hypotheses.decided(None), None, "{second:?}");
        // It was the best of all in three scans.
        let best: &[(f64, f64)] = &[(5.1, 0.3)];
        drive(&mut hypotheses, &[best; 2], -0.4);
        assert!((hypotheses.decided(None).unwrap().x() - 7.1).abs() < 1e-12);
        // A scan that fits it nowhere: it stays the likeliest, and is not sure.
        drive(&mut hypotheses, &[&[(90.0, 0.3)]], -0.4);
        assert!((hypotheses.all[0].pose_in_world.x() - 8.1).abs() < 1e-12);
        assert_eq!(hypotheses.decided(None), None);
    }

    /// A belief that is here and nowhere else.
    fn mode_at(x_m: f64) -> Mode {
        let pose_in_world = SE2::new(x_m, 0.0, 0.0);
        Mode { pose_in_world, covariance: covariance(), share: 1.0, second_share: 0.0 }
    }

    #[test]
    fn a_place_that_two_scans_fit_far_worse_is_denied() {
        let near: &[(f64, f64)] = &[(9.0, 0.4), (0.0, 0.3), (30.0, 0.1)];
        let mut hypotheses = Hypotheses::default();
        assert!(!hypotheses.deny(&mode_at(0.0)));
        drive(&mut hypotheses, &[near], -0.4);
        assert!(!hypotheses.deny(&mode_at(31.0)), "after one scan");
        drive(&mut hypotheses, &[near], -0.4);
        // By hand: 1.6 and 4.8 less than the likeliest, which it moved two metres with.
        let denied = [11.0, 2.0, 32.0, 50.0].map(|x_m| hypotheses.deny(&mode_at(x_m)));
        assert_eq!(denied, [false, false, true, true]);
    }

    #[test]
    fn one_scan_is_enough_for_an_answer_where_it_fits_in_one_place() {
        let mode = mode_at(1.0);
        assert!(!Hypotheses::default().agree(&mode));
        for (places, is_enough) in
            [(&[(0.0, 0.4)][..], true), (&[(0.0, 0.4), (9.0, 0.3)][..], false)]
        {
            let mut hypotheses = Hypotheses::default();
            drive(&mut hypotheses, &[places], -0.4);
            assert_eq!(hypotheses.agree(&mode), is_enough, "{places:?}");
        }
        // By hand: 5.6 behind.
        let mut hypotheses = Hypotheses::default();
        let unlike: &[(f64, f64)] = &[(0.0, 0.4), (9.0, 0.05)];
        drive(&mut hypotheses, &[unlike; 2], -0.4);
        assert!(hypotheses.agree(&mode_at(2.0)));
        hypotheses.was_found = true;
        assert!(!hypotheses.agree(&mode_at(2.0)));
    }

    #[test]
    fn a_place_that_others_fit_better_now_and_then_is_not_decided() {
        let apart: &[(f64, f64)] = &[(0.0, 0.3), (200.0, -0.4)];
        let better: &[(f64, f64)] = &[(40.0, 0.35), (0.0, 0.3)];
        let alone: &[(f64, f64)] = &[(0.0, 0.3)];
        let mut scans = vec![apart; 4];
        scans.push(better);
        scans.extend([alone; 5]);
        // By hand: 12 behind before the scan that fits it, and 0.4 less.
        for (count, margin, is_decided) in [(4, 12.0, false), (5, 11.6, false), (10, 15.0, true)] {
            let mut hypotheses = Hypotheses::default();
            drive(&mut hypotheses, &scans[..count], -0.4);
            assert!(hypotheses.margin() >= margin - 1e-9, "{count}: {}", hypotheses.margin());
            assert_eq!(hypotheses.decided(None).is_some(), is_decided, "{count}");
        }
        let mut hypotheses = Hypotheses::default();
        drive(&mut hypotheses, &scans[..9], -0.4);
        assert_eq!(hypotheses.decided(None), None, "{}", hypotheses.margin());
        // Four scans are enough where the wheels took a robot that was found before.
        let here = SE2::new(11.0, 0.0, 0.0);
        assert_eq!(hypotheses.decided(Some(here)), None);
        hypotheses.was_found = true;
        assert!(hypotheses.decided(Some(here)).is_some());
        assert_eq!(hypotheses.decided(Some(SE2::new(13.0, 0.0, 0.0))), None);
    }

    #[test]
    fn a_turn_shows_a_new_place_where_the_laser_does_not_see_all_round() {
        for (fov_deg, is_new) in [(360.0_f64, false), (270.0, true), (180.0, true)] {
            let mut hypotheses = Hypotheses::of_view(fov_deg.to_radians());
            drive(&mut hypotheses, &[&[(0.0, 0.4)]], -0.4);
            let turn =
                |x_m, rad| Motion { now_in_then: SE2::new(x_m, 0.0, rad), ..Motion::default() };
            hypotheses.move_by(&turn(0.0, 3.0));
            assert_eq!(hypotheses.is_new_place(), is_new, "{fov_deg}");
            hypotheses.clear();
            hypotheses.take(&fits(&[(0.0, 0.4)], -0.4));
            hypotheses.move_by(&turn(0.0, -0.7));
            assert_eq!(hypotheses.is_new_place(), is_new, "{fov_deg}");
            hypotheses.move_by(&turn(0.2, 0.0));
            assert!(hypotheses.is_new_place());
        }
    }

    #[test]
    fn of_two_places_that_look_alike_none_is_decided() {
        let mut hypotheses = Hypotheses::default();
        let alike: &[(f64, f64)] = &[(30.0, 0.31), (0.0, 0.3)];
        drive(&mut hypotheses, &[alike; 60], -0.4);
        assert_eq!(hypotheses.decided(None), None);
        // Nor are those that were not listed because there are many.
        let mut hypotheses = Hypotheses::default();
        let mut scans = vec![alike; 4];
        scans.extend([&alike[..1]; 8]);
        drive(&mut hypotheses, &scans, 0.3);
        assert_eq!(hypotheses.decided(None), None);
        let mut hypotheses = Hypotheses::default();
        drive(&mut hypotheses, &scans, -0.4);
        assert!(hypotheses.decided(None).is_some());
    }
}
