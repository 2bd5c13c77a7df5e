//! The motion from the key scan to a scan: by the wheels as they should be. Where that does not
//! fit, or leaps away from the last match, a search in the newest key scans decides.

use rusty_geometry::SE2;

use super::Tracker;
use super::doubts::{doubted, lost, slipped};
use crate::Motion;
use crate::icp::{Fused, Match, NoMatch, Ray, Surface, match_scans};
use crate::submap::{EQUAL_SCORE, Placement, Submap, Unseen, Window, is_meagre};

/// A match that surprises the wheels more than this (χ² of three numbers, once in
/// ten thousand) says that they slipped.
const SLIPPED_CHI2: f64 = 21.1;

/// Half of the windows in which a match is searched (m and rad), the next one where the
/// best pose of the one before fits badly: wheels are off by 0.3 m or 12 degrees now and
/// then, and a scan may have come late while the robot turned.
const WINDOWS: [(f64, f64); 2] = [(0.5, 0.5), (1.0, 0.8)];
/// Half of the window around the wheels in which a pose is theirs.
const NEAR: (f64, f64) = (0.05, 0.025);
/// A pose fits the submap with this score at least, and more where few ends may fit by
/// chance: score and part of 1/√n.
const FITS_SCORE: [f64; 2] = [0.4, 1.0];
/// A pose that scores this much more than all others far from it leads,
const LEADS_BY: f64 = 0.1;
/// and fits with this score if wheels that slipped may be there: many beams of the scan may
/// be wrong.
const LEADER_SCORE: f64 = 0.3;
/// A scan with fewer ends is too sparse for a score to refute a match of it.
const SPARSE_ENDS: usize = 60;

/// The score with which a scan fits.
fn fits_score(rays: &[Ray]) -> f64 {
    let [many, chance] = FITS_SCORE;
    many + chance / (rays.len().max(1) as f64).sqrt()
}

/// A scan that was matched.
pub(super) struct Matched {
    /// The motion since the key scan by wheels and this scan.
    pub fused: Fused,
    pub found: Match,
    /// Whether that is elsewhere than the wheels say.
    pub searched: bool,
}

/// A match, and what it says together with the wheels.
type Told = (Fused, Match);

/// Whether the wheels did what they do.
fn is_usual((fused, _): &Told) -> bool {
    fused.innovation.nis <= SLIPPED_CHI2
}

/// Whether a pose is no greater surprise to a motion than wheels that slipped are.
fn is_within(motion: &Motion, pose: &SE2) -> bool {
    let off = pose.boxminus(&motion.now_in_then);
    let inverse = motion.covariance.try_inverse();
    inverse.is_some_and(|inverse| (off.transpose() * inverse * off).x <= SLIPPED_CHI2)
}

fn by_book((fused, found): Told) -> Matched {
    Matched { fused, found, searched: false }
}

impl Tracker {
    /// The motion since the key scan by wheels and this scan, and the share of its
    /// points that match: with the wheels as they should be, or where that does not fit,
    /// or is not where the last scan and the wheels since then lead, near the best pose in
    /// the submap. Wheels that turn while something holds the robot fit too, where walls
    /// hardly measure the distance.
    pub(super) fn matched(&self, surface: &Surface, scan: &Surface) -> Result<Matched, NoMatch> {
        let guess = self.to_scan.now_in_then;
        let book = self.match_from(surface, scan, &guess, &self.wheels.since_key());
        let expected = slipped(&self.to_scan);
        let goes_on =
            |told: &Told| self.fits(told) && is_within(&expected, &told.0.motion.now_in_then);
        if book.as_ref().is_ok_and(goes_on) || matches!(book, Err(NoMatch::FewEnds { .. })) {
            return book.map(by_book);
        }
        if is_meagre(&self.laser, scan.rays()) {
            let told = book?;
            return is_usual(&told).then(|| by_book(told)).ok_or(NoMatch::Narrow);
        }
        self.matched_in_submap(surface, scan, book)
    }

    /// Whether a match is good and the wheels did what they do.
    fn fits(&self, told: &Told) -> bool {
        told.1.share >= self.options.key_share && is_usual(told)
    }

    /// The match that begins at a guess, with wheels that moved so.
    fn match_from(
        &self,
        surface: &Surface,
        scan: &Surface,
        guess: &SE2,
        wheels: &Motion,
    ) -> Result<Told, NoMatch> {
        let found = match_scans(surface, &self.laser, scan, guess, wheels, &self.options.icp)?;
        let fused = found.evidence.fuse(wheels).ok_or(NoMatch::NoSolution)?;
        Ok((fused, found))
    }

    /// The match near the best pose in the submap, where `book`, that by the wheels as they
    /// should be, does not fit or leaps. Where no pose of the submap is good enough, a `book`
    /// that fits stays.
    fn matched_in_submap(
        &self,
        surface: &Surface,
        scan: &Surface,
        book: Result<Told, NoMatch>,
    ) -> Result<Matched, NoMatch> {
        let rays = scan.rays();
        let (guess, wheels) = (self.to_scan.now_in_then, &self.wheels.since_key());
        let recent = self.recent.iter().map(|(pose, rays)| (*pose, rays.as_slice()));
        let map = Submap::new(&self.laser, recent, Unseen::LeftOut);
        let [best, other] = self.searched(&map, rays);
        let leads = best.is_some_and(|best| best.leads(other.as_ref(), LEADS_BY));
        let (slipped, lost) = (slipped(wheels), lost(wheels));
        let is_slip = best.is_some_and(|best| is_within(&slipped, &best.pose));
        let enough = if leads && is_slip { LEADER_SCORE } else { fits_score(rays) };
        let Some(best) = best.filter(|best| best.score >= enough) else {
            return match book {
                Ok(told) if self.fits(&told) => Ok(by_book(told)),
                book => Err(book.err().unwrap_or(NoMatch::NoSolution)),
            };
        };
        let is_best = |(fused, _): &Told| {
            rays.len() < SPARSE_ENDS
                || map.score(rays, &fused.motion.now_in_then) >= best.score - EQUAL_SCORE
        };
        // How surprising it was is told as the wheels should have been.
        let innovation = book.as_ref().ok().map(|(fused, _)| fused.innovation);
        let as_expected = |(fused, found): Told| {
            let innovation = innovation.unwrap_or(fused.innovation);
            let motion = match other {
                Some(other) if !leads => doubted(&fused.motion, &best.pose, &other.pose),
                _ => fused.motion,
            };
            Matched { fused: Fused { motion, innovation }, found, searched: true }
        };
        let usual = |told: &Told| is_usual(told) && is_best(told);
        if book.as_ref().is_ok_and(usual) {
            return book.map(by_book);
        }
        // Where the wheels fit as well as any pose does, they are not lost.
        let (half_m, half_rad) = NEAR;
        let centre = wheels.now_in_then;
        let [near, _] = map.search(rays, &Window::new(centre, half_m, half_rad));
        let near = near.filter(|near| near.score >= best.score - EQUAL_SCORE);
        let (places, wheels) = match near {
            Some(near) => ([Some(near), None], &slipped),
            None => ([Some(best), other], &lost),
        };
        let places = places.into_iter().flatten().map(|place| (place.pose, wheels));
        for (start, wheels) in std::iter::once((guess, &slipped)).chain(places) {
            if let Some(told) = self.match_from(surface, scan, &start, wheels).ok().filter(usual) {
                return Ok(as_expected(told));
            }
        }
        let spread = map.spread(rays, &near.unwrap_or(best).pose);
        let evidence = spread.ok_or(NoMatch::NoSolution)?.into();
        let found = Match { evidence, share: 0.0, pairs: 0 };
        let fused = found.evidence.fuse(wheels).ok_or(NoMatch::NoSolution)?;
        Ok(as_expected((fused, found)))
    }

    /// The best poses of a scan in a submap, in the smallest window with a good one.
    fn searched(&self, map: &Submap, rays: &[Ray]) -> [Option<Placement>; 2] {
        let centre = self.to_scan.now_in_then;
        let search = |(half_m, half_rad)| map.search(rays, &Window::new(centre, half_m, half_rad));
        let [small, wide] = WINDOWS;
        let found = search(small);
        let is_good = found[0].is_some_and(|best| best.score >= fits_score(rays));
        if is_good { found } else { search(wide) }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};

    use super::*;

    #[test]
    fn wheels_that_slipped_are_not_anywhere() {
        let wheels = Motion {
            now_in_then: SE2::new(0.9, -0.06, -0.12),
            covariance: Matrix3::from_diagonal(&Vector3::new(1e-5, 4e-4, 1.5e-3)),
        };
        let may_be_at = |by: [f64; 3]| {
            is_within(&slipped(&wheels), &wheels.now_in_then.boxplus(&Vector3::from(by)))
        };
        // Off by as much as on the recordings, and by a scan that turned the other way.
        assert!(may_be_at([0.1, 0.05, 0.21]));
        assert!(!may_be_at([-0.3, 0.0, -0.75]));
        assert!(!may_be_at([0.0, 0.6, 0.0]));
    }
}
