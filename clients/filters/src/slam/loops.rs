//! Loops of the pose graph: the newest key scan, matched with old ones.
//!
//! Sources: W. Hess, D. Kohler, H. Rapp, D. Andor, *Real-time loop closure in 2D LIDAR
//! SLAM*, ICRA 2016, for the search in a submap by branch and bound; E. Olson, *Recognizing
//! places using spectrally clustered local matches*, Robotics and Autonomous Systems 57
//! (2009), for loops that have to agree with each other.
//!
//! Departures: a loop of a search is confirmed by a single other one. Later ones that
//! contradict the graph lose weight in it ([`crate::pose_graph`]). A pose that fits walls
//! from behind is refused.

use nalgebra::{Matrix3, Vector3};
use rusty_geometry::{SE2, trig};

use super::{LoopOptions, Slam};
use crate::Motion;
use crate::icp::{Ray, Side, match_scans};
use crate::pose_graph::{Constraint, Kind};
use crate::submap::{EQUAL_SCORE, Submap, Unseen, Window, is_narrow, scored};
use crate::tangent::symmetric;

/// A loop that surprises the graph more (χ² of three numbers) is refused. That is far
/// beyond chance (16 once in a thousand), because motions through real rooms are
/// less certain than they say; what is doubtful then loses weight.
const LOOP_CHI2: f64 = 50.0;
/// What part of a loop's information counts: three loops and a chain share a scan.
const LOOP_SHARE: f64 = 0.5;
/// A search begins only where the graph is not this sure (m, rad).
const SURE_M: f64 = 0.15;
const SURE_RAD: f64 = 0.15;
/// How far a search holds poses likely: in deviations, at least and at most (m, rad).
const LIKELY_STD: f64 = 3.0;
const LIKELY_M: [f64; 2] = [0.5, 6.0];
const LIKELY_RAD: [f64; 2] = [0.1, 0.8];
/// It looks farther by this, up to the same most. Where the graph is too sure, and the
/// right pose is not in the window, another place may fit best, in two searches alike.
const LOOK_FARTHER: f64 = 5.0 / 3.0;
/// Key scans before and after an old one that are in its submap.
const NEIGHBOURS: usize = 5;
/// The best pose of a window has this score at least, and leads the best other one by this.
const FITS_SCORE: f64 = 0.5;
const LEAD_SCORE: f64 = 0.06;
/// Rays that end this near (m) to walls which the submap knows from the other side only are at
/// most this part of a score. The map has no sides: where two corridors meet, the left wall of
/// one, seen from behind, would be the right wall of the other.
const BEHIND: f64 = 0.4;
const BEHIND_M: f64 = 0.15;
/// Key scans of a submap that the scan is matched with, the nearest ones.
const MATCHED_KEYS: usize = 3;
/// Deviations of the pose that a search found, for such a match (m, rad).
const FOUND_STD: Vector3<f64> = Vector3::new(0.3, 0.3, 0.1);
/// A match this far from that pose (m) has to score as much.
const SLIDES_M: f64 = 0.2;
/// Two loops confirm each other if their new key scans are at most this many apart,
const CONFIRM_WITHIN: usize = 12;
/// and their poses differ by this χ² at most, with these deviations (m, rad).
const CONFIRM_CHI2: f64 = 16.0;
const CONFIRM_STD: Vector3<f64> = Vector3::new(0.1, 0.1, 0.03);

/// A motion from one key scan to another, and the information of its error.
type Measured = (SE2, Matrix3<f64>);

impl Slam {
    /// Matches the newest key scan with old ones near it. One that is narrow is not searched, and
    /// that of a laser that sees little is not matched, because it fits nearby as well. Returns
    /// whether a loop was closed.
    pub(super) fn close_loops(&mut self) -> bool {
        let Some(newest) = self.seen.last() else { return false };
        let laser = self.tracker.laser();
        let is_narrow = is_narrow(laser, newest.surface.rays());
        if is_narrow && laser.sees_little() {
            return false;
        }
        let candidates = self.candidates();
        if candidates.is_empty() {
            return false;
        }
        let Some(expected) = self.graph.to_last(&candidates) else { return false };
        let (mut loops, mut searched) = (Vec::new(), Vec::<usize>::new());
        for (old, expected) in candidates.into_iter().zip(&expected) {
            if let Some(window) = window(expected) {
                let is_new = searched.iter().all(|other| other.abs_diff(old) > NEIGHBOURS);
                if is_new && !is_narrow {
                    searched.push(old);
                    let found = self.searched(old, &window);
                    let new = found.map(|(from, found)| self.constraint(from, found));
                    loops.extend(new.into_iter().flat_map(|new| self.confirmed(new)));
                }
            } else if let Some(found) = self.matched(old, &expected.now_in_then, expected) {
                loops.push(self.constraint(old, found));
            }
        }
        let closed = !loops.is_empty();
        loops.into_iter().for_each(|new| self.graph.constrain(new));
        closed
    }

    fn constraint(&self, from: usize, (motion, information): Measured) -> Constraint {
        let information = information * LOOP_SHARE;
        Constraint { from, to: self.seen.len() - 1, motion, information, kind: Kind::Loop }
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
                (farness(&apart), trig::hypot(apart.x(), apart.y()), k)
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

    /// The motion to the newest key scan from one near an old one, by the best pose of a
    /// window in the submap of these. Where no single scan matches there, the scores of
    /// the submap measure the motion from the old one.
    fn searched(&self, old: usize, window: &Window) -> Option<(usize, Measured)> {
        let (poses, rays) = (self.graph.poses(), self.seen.last()?.surface.rays());
        // No scan of the submap is a neighbour of the new one.
        let last = (old + NEIGHBOURS).min(self.seen.len().checked_sub(NEIGHBOURS + 2)?);
        let near = old.saturating_sub(NEIGHBOURS)..=last;
        let back = poses[old].inverse();
        let in_map = |k: usize| back * poses[k];
        let scans = near.clone().map(|k| (in_map(k), self.seen[k].surface.rays()));
        let map = Submap::new(self.tracker.laser(), scans, Unseen::Misses);
        let [best, other] = map.search(rays, window);
        let best = best.filter(|best| best.score >= FITS_SCORE)?;
        if !best.leads(other.as_ref(), LEAD_SCORE) {
            return None;
        }
        let apart = |k: usize| (k, in_map(k).inverse() * best.pose);
        let mut keys: Vec<(usize, SE2)> = near.map(apart).collect();
        keys.sort_by(|(i, a), (j, b)| farness(a).total_cmp(&farness(b)).then(i.cmp(j)));
        let covariance = Matrix3::from_diagonal(&FOUND_STD.component_mul(&FOUND_STD));
        for &(k, guess) in keys.iter().take(MATCHED_KEYS) {
            let found = Motion { now_in_then: guess, covariance };
            // Along a corridor a match may slide to where the scan fits worse.
            let fits = |(motion, _): &Measured| {
                let slid = guess.inverse() * *motion;
                trig::hypot(slid.x(), slid.y()) <= SLIDES_M
                    || map.score(rays, &(in_map(k) * *motion)) >= best.score - EQUAL_SCORE
            };
            if let Some(measured) = self.matched(k, &guess, &found).filter(fits) {
                return Some((k, measured));
            }
        }
        if self.share_from_behind(&keys) > BEHIND * best.score {
            return None;
        }
        let spread = map.spread(rays, &best.pose)?;
        let information = symmetric(&spread.covariance.try_inverse()?);
        Some((old, (spread.now_in_then, information)))
    }

    /// The share of the newest rays that count which end on walls that these key scans, each with
    /// the newest pose in its frame, saw from the other side, and none of them from this one.
    fn share_from_behind(&self, keys: &[(usize, SE2)]) -> f64 {
        let Some(newest) = self.seen.last() else { return 0.0 };
        let is_on = |ray: &Ray, side: Side| {
            let sees =
                |(k, now): &(usize, SE2)| self.seen[*k].surface.has_wall(ray, now, BEHIND_M, side);
            keys.iter().any(sees)
        };
        let is_behind = |ray: &&Ray| !is_on(ray, Side::Front) && is_on(ray, Side::Behind);
        let rays: Vec<&Ray> = scored(newest.surface.rays()).collect();
        let behind = rays.iter().copied().filter(is_behind).count();
        behind as f64 / rays.len().max(1) as f64
    }

    /// The motion from an old key scan to the newest, if they match near a guess and that
    /// is no surprise to what is expected.
    fn matched(&self, old: usize, guess: &SE2, expected: &Motion) -> Option<Measured> {
        let scan = &self.seen.last()?.surface;
        let icp = &self.options.front.icp;
        let (surface, laser) = (&self.seen[old].surface, self.tracker.laser());
        let found = match_scans(surface, laser, scan, guess, expected, icp).ok()?;
        let surprise = found.evidence.fuse(expected)?.innovation.nis;
        let overlaps = found.pairs * 3 > scan.rays().len();
        if surprise > LOOP_CHI2 || found.share < self.options.closing.loop_share || !overlaps {
            return None;
        }
        found.evidence.constraint()
    }

    /// A new loop of a search and the earlier ones that it confirms. Without one, it waits
    /// for the loops of the next key scans.
    fn confirmed(&mut self, new: Constraint) -> Vec<Constraint> {
        let poses = self.graph.poses();
        let agree = |old: &Constraint| {
            let since = poses[old.to].inverse() * poses[new.to];
            let by_old = poses[old.from] * old.motion * since;
            let off = (poses[new.from] * new.motion).boxminus(&by_old);
            old.to != new.to && off.component_div(&CONFIRM_STD).norm_squared() < CONFIRM_CHI2
        };
        let recent = self.unconfirmed.iter().filter(|old| old.to + CONFIRM_WITHIN >= new.to);
        let (mut agreed, mut waiting): (Vec<_>, Vec<_>) = recent.copied().partition(agree);
        if agreed.is_empty() {
            waiting.push(new);
        } else {
            agreed.push(new);
        }
        self.unconfirmed = waiting;
        agreed
    }
}

/// How little two scans have in common whose poses are this far apart, m: half a metre is
/// worth a sixth of a turn, because scans that look elsewhere have little in common.
fn farness(apart: &SE2) -> f64 {
    trig::hypot(apart.x(), apart.y()) + 0.5 * apart.theta().abs()
}

/// The window of a search around an expected motion; `None` where the graph is sure.
fn window(expected: &Motion) -> Option<Window> {
    let deviation = |k: usize| expected.covariance[(k, k)].max(0.0).sqrt();
    let (m, rad) = (deviation(0).max(deviation(1)), deviation(2));
    let likely =
        |deviation: f64, [least, most]: [f64; 2]| (LIKELY_STD * deviation).clamp(least, most);
    let (likely_m, likely_rad) = (likely(m, LIKELY_M), likely(rad, LIKELY_RAD));
    (m >= SURE_M || rad >= SURE_RAD).then(|| Window {
        half_m: (LOOK_FARTHER * likely_m).min(LIKELY_M[1]),
        half_rad: (LOOK_FARTHER * likely_rad).min(LIKELY_RAD[1]),
        ..Window::new(expected.now_in_then, likely_m, likely_rad)
    })
}

#[cfg(test)]
#[path = "loops_tests.rs"]
mod tests;
