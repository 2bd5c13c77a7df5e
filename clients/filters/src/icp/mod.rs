//! Matching two scans: iterated closest points with the point-to-line metric.
//!
//! Source: A. Censi, *An ICP variant using a point-to-line metric*, ICRA 2008
//! (PL-ICP): points of the scan now are paired with lines of the scan then, the
//! worst pairs are left out, and the pose that minimises the squared distances
//! from the lines is taken, until it stays; convergence is quadratic.
//!
//! Departures, and why:
//! * Lines are fitted to neighbouring rays (`surface.rs`), as many as fit, where
//!   Censi takes the two nearest points. Beams two degrees apart with 2 cm of
//!   noise end 3 cm apart at 1 m: two points say little about a direction there.
//! * The minimum on SE(2) is found by Gauss–Newton, one step between pairings;
//!   the quartic of Censi's closed form minimises the same metric. Residuals are
//!   weighted by their inverse variance.
//! * A prior takes part in every step. Along a corridor it is all there is, and
//!   without it pairs of noise would carry the pose away.
//! * Neighbours come from the beams' order: a wall within reach of a point can
//!   only be met by beams that pass near it, which is the bound behind Censi's
//!   jump tables.
//! * Pairs are trimmed by their residuals in deviations, no further than a
//!   multiple of a quantile (his `outliers_adaptive`).
//! * While pairs reach far, they are as unsure as the prior is of the distance from their
//!   wall: with a guess that is a degree off, points at 10 m would be trimmed, and those
//!   nearby would decide the heading alone.
//! * A point is not paired with a wall that faces another way than the wall that its scan has there.
//!   Near a corner of a corridor such pairs would hold the pose along the corridor where
//!   it happens to be.
//! * Neither holds for a laser that sees little, where few pairs are all there is: with a view
//!   of 57° the ATE of `scan-match` would be 0.16 m in place of 0.11 m (80 seeds of the table
//!   in `docs/filters.md`).
//! * Residuals beyond what the models say make the result less certain.
//!
//! From within some 0.4 m and 20° in a room with walls in both directions it
//! finds the pose (see `tests.rs`, which measures it).

mod evidence;
mod laser;
mod lone;
mod surface;
#[cfg(test)]
mod tests;

use clap::Args;
use rusty_geometry::SE2;
use thiserror::Error;

pub use self::evidence::{Evidence, Fused};
use self::evidence::{Pair, loosen, pairs};
pub use self::laser::{Laser, Ray};
pub use self::lone::without_lone;
use self::surface::Nearest;
pub use self::surface::{Piece, Side, Surface};
use crate::Motion;
use crate::numbers::{positive, share};

/// Fewer ends than this are no scan, fewer pairs no match.
pub const FEWEST: usize = 12;
/// Steps at most; a good match takes about eight.
const MOST_STEPS: u32 = 40;
/// A step below this many deviations of the result is the last.
const SMALL_STEP: f64 = 1e-3;
/// If steps still are smaller than this after the most of them, pairs come and go
/// at the edge of trimming, and the pose is as good as any of those around it.
const RESTLESS_STEP: f64 = 0.3;
/// Pairs within this many deviations are never left out.
const SURE_DEVIATIONS: f64 = 3.0;
/// From one step to the next the reach shrinks to this part, down to a quarter.
const REACH_SHRINKS: f64 = 0.8;
/// Upper limit of the deviation that the prior adds to a pair while the reach shrinks, as a
/// part of the reach.
const UNSURE_PART: f64 = 0.3;

/// How scans are matched.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
#[command(next_help_heading = "Scan matching (Censi, PL-ICP)")]
pub struct IcpOptions {
    /// Maximum initial distance of a point from its wall, m
    #[arg(long, value_name = "METRES", default_value_t = 0.6, value_parser = positive)]
    pub pair_within_m: f64,

    /// Standard deviation of the roughness of walls, m
    #[arg(long, value_name = "METRES", default_value_t = 0.005, value_parser = positive)]
    pub roughness_m: f64,

    /// Minimum share of paired points in a match
    #[arg(long, value_name = "0..1", default_value_t = 0.4, value_parser = share)]
    pub least_share: f64,
}

crate::numbers::default_of_command_line!(IcpOptions);

/// Two scans that fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Match {
    /// What it says of the motion between them.
    pub evidence: Evidence,
    /// Which share of the points that the first scan looked at lies on its walls,
    /// within three deviations.
    pub share: f64,
    /// Pairs that counted.
    pub pairs: usize,
}

/// Why two scans give no motion.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum NoMatch {
    /// Too little was met by the scan.
    #[error("only {found} beams met something, {FEWEST} are needed")]
    FewEnds {
        /// How many did.
        found: usize,
    },
    /// Too little of the reference is a wall.
    #[error("only {found} pieces of wall are in the reference scan, {FEWEST} are needed")]
    FewPieces {
        /// How many are.
        found: usize,
    },
    /// Too few points lie near a wall.
    #[error("only {pairs} of {looked_at} points lie on a wall of the reference scan")]
    FewPairs {
        /// How many do.
        pairs: usize,
        /// How many it looked at.
        looked_at: usize,
    },
    /// The match surprises the wheels, and the scan is too narrow to be searched elsewhere.
    #[error("the match surprises the wheels, and what the scan met is too narrow for a search")]
    Narrow,
    /// It did not come to rest.
    #[error("no rest after {MOST_STEPS} steps: the last one was {deviations} deviations")]
    Restless {
        /// Size of the last step.
        deviations: f64,
    },
    /// An invalid number.
    #[error("the equations have no solution: a range or the guess is no number")]
    NoSolution,
}

/// Where the body is now in the frame of the body then, by the scan now and the walls of
/// the scan then (`surface`), both of `laser`.
///
/// `guess` is where to begin. `prior` is what is known of the motion beforehand;
/// it holds the pose where the scans say nothing, and is no part of the evidence
/// that comes back.
///
/// # Errors
/// [`NoMatch`] says why there is none.
pub fn match_scans(
    surface: &Surface,
    laser: &Laser,
    scan: &Surface,
    guess: &SE2,
    prior: &Motion,
    options: &IcpOptions,
) -> Result<Match, NoMatch> {
    let rays = scan.rays();
    if rays.len() < FEWEST {
        return Err(NoMatch::FewEnds { found: rays.len() });
    }
    if surface.pieces().len() < FEWEST {
        return Err(NoMatch::FewPieces { found: surface.pieces().len() });
    }
    let viewpoint = laser.view().viewpoint;
    let still_m = options.pair_within_m * 0.25;
    let sees_little = laser.sees_little();
    let counts = |pair: &Pair| pair.is_same_way || sees_little;
    let (mut now, mut reach_m) = (*guess, options.pair_within_m);
    let mut deviations = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let mut pairs = pairs(surface, scan, &viewpoint, &now, reach_m, Nearest::ByDistance);
        pairs.retain(counts);
        if reach_m > still_m && !sees_little {
            let unsure_m = UNSURE_PART * reach_m;
            let most_m2 = unsure_m * unsure_m;
            loosen(&mut pairs, surface, rays, &now, &prior.covariance, most_m2);
        }
        let pairs = trimmed(pairs);
        enough(surface, rays, &now, pairs.len(), 0.0)?;
        let evidence = Evidence::of(surface, rays, &pairs, &now, false);
        let step = evidence.step(prior).ok_or(NoMatch::NoSolution)?;
        now = now.boxplus(&step);
        if !now.is_finite() {
            return Err(NoMatch::NoSolution);
        }
        deviations = (step.transpose() * evidence.gain * step).x.max(0.0).sqrt();
        if deviations < SMALL_STEP && reach_m <= still_m {
            break;
        }
        reach_m = (reach_m * REACH_SHRINKS).max(still_m);
    }
    if deviations > RESTLESS_STEP {
        return Err(NoMatch::Restless { deviations });
    }
    let mut pairs = trimmed(pairs(surface, scan, &viewpoint, &now, reach_m, Nearest::ByMiddle));
    let sure = pairs.iter().filter(|pair| pair.surprise() <= SURE_DEVIATIONS).count();
    let share = enough(surface, rays, &now, sure, options.least_share)?;
    // Those that face another way lie on walls, so they are in the share; evidence they are not.
    pairs.retain(counts);
    enough(surface, rays, &now, pairs.len(), 0.0)?;
    let squares: f64 = pairs.iter().map(|p| p.surprise() * p.surprise()).sum();
    // In deviations: 1 for what the models say, more where walls are not what they
    // were, which is separate noise.
    let misfit = (squares / pairs.len() as f64).sqrt();
    let mut evidence = Evidence::of(surface, rays, &pairs, &now, true);
    evidence.noise *= (misfit * misfit).max(1.0);
    Ok(Match { evidence, share, pairs: pairs.len() })
}

/// The pairs without those whose residual is far beyond that of most.
fn trimmed(mut pairs: Vec<Pair>) -> Vec<Pair> {
    let mut sizes: Vec<f64> = pairs.iter().map(Pair::surprise).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    // Of normal residuals 70 % are within one deviation or so.
    let usual = sizes.get(sizes.len() * 7 / 10).copied().unwrap_or_default();
    let limit = SURE_DEVIATIONS.max(2.0 * usual);
    pairs.retain(|pair| pair.surprise() <= limit);
    pairs
}

/// The share of paired points among those that the reference looked at.
fn enough(
    surface: &Surface,
    rays: &[Ray],
    now: &SE2,
    pairs: usize,
    least_share: f64,
) -> Result<f64, NoMatch> {
    let seen = rays.iter().filter(|ray| surface.looks_at(&now.transform_point(&ray.point)));
    let looked_at = seen.count().max(1);
    let share = pairs as f64 / looked_at as f64;
    if pairs < FEWEST || share < least_share {
        return Err(NoMatch::FewPairs { pairs, looked_at });
    }
    Ok(share)
}
