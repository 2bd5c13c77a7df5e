//! Where to begin a match whose first guess may be far off.
//!
//! Source of the idea: E. Olson, *Real-time correlative scan matching*, ICRA 2009:
//! all poses of a window are scored, coarsely, and the best are looked at closely.
//!
//! Departure: a pose is scored by how near its points lie to the fitted walls,
//! with the pairing of ICP itself, not in a table of likelihoods. Windows here are
//! small, and nothing has to be prepared.

use nalgebra::Vector3;
use rusty_geometry::SE2;

use super::evidence::pairs;
use super::{IcpOptions, Laser, Match, NoMatch, Ray, Surface, match_scans};
use crate::Motion;

/// Distance between neighbouring poses, m.
const STEP_M: f64 = 0.25;
/// Angle between neighbouring poses, rad.
const STEP_RAD: f64 = 0.08;
/// A point this far from every wall scores nothing, m.
const REACH_M: f64 = 0.35;
/// Number of best poses from which a match begins.
const STARTS: usize = 4;
/// Steps to each side at most: a window is never wider than 1.5 m and 0.48 rad to
/// each side, however unsure the guess. One that wide takes 2197 poses.
const MOST: f64 = 6.0;
/// Rays that are scored, about.
const MOST_RAYS: usize = 60;

/// The poses within `half` (m, m, rad) of `centre` that fit best, the best
/// first: where [`match_scans`] may begin.
fn starts(
    surface: &Surface,
    laser: &Laser,
    rays: &[Ray],
    centre: &SE2,
    half: &Vector3<f64>,
) -> Vec<SE2> {
    let viewpoint = laser.view().viewpoint;
    let few: Vec<Ray> = rays.iter().step_by(1 + rays.len() / MOST_RAYS).copied().collect();
    let steps = |half: f64, step: f64| (half / step).ceil().min(MOST) as i32;
    let (along, around) = (steps(half.x.max(half.y), STEP_M), steps(half.z, STEP_RAD));
    let mut scored: Vec<(f64, SE2)> = Vec::new();
    for turn in -around..=around {
        for x in -along..=along {
            for y in -along..=along {
                let pose = SE2::new(
                    centre.x() + STEP_M * f64::from(x),
                    centre.y() + STEP_M * f64::from(y),
                    centre.theta() + STEP_RAD * f64::from(turn),
                );
                let found = pairs(surface, &few, &viewpoint, &pose, REACH_M);
                let near = found.iter().map(|pair| 1.0 - (pair.residual_m / REACH_M).abs());
                scored.push((near.sum::<f64>(), pose));
            }
        }
    }
    scored.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    scored.truncate(STARTS);
    scored.into_iter().map(|(_, pose)| pose).collect()
}

/// Matches two scans from a guess that may be off by `half` (m, m, rad), or by
/// 1.5 m and 0.48 rad where that is more: no search goes farther. The match with the
/// greatest share is returned.
///
/// # Errors
/// [`NoMatch`] of the last attempt, where none succeeds.
pub fn match_widely(
    surface: &Surface,
    laser: &Laser,
    rays: &[Ray],
    prior: &Motion,
    half: &Vector3<f64>,
    options: &IcpOptions,
) -> Result<Match, NoMatch> {
    let mut best: Result<Match, NoMatch> = Err(NoMatch::NoSolution);
    for start in starts(surface, laser, rays, &prior.now_in_then, half) {
        let found = match_scans(surface, laser, rays, &start, prior, options);
        match (&found, &best) {
            (Ok(new), Ok(old)) if new.share <= old.share => {}
            (Err(_), Ok(_)) => {}
            _ => best = found,
        }
    }
    best
}
