//! From where the laps ended to what is wrong with the robot.
//!
//! Source: J. Borenstein and L. Feng, *Measurement and Correction of Systematic
//! Odometry Errors in Mobile Robots*, IEEE Transactions on Robotics and
//! Automation 12(6), 1996. With the centres of gravity (x, y) of the returns of
//! both ways, the side L and the nominal wheelbase b, they split the error into
//! type A, α, by which every corner falls short (both ways turn too little), and
//! type B, β, by which every side is bent to the left (one way turns too little,
//! the other too much). To first order in both
//!
//! * cw:  x = −2L(α + β), y = −2L(α + β)
//! * ccw: x = −2L(α − β), y = +2L(α − β)
//!
//! which follows from summing four sides whose directions are off by (k − 1)α
//! and by (k − ½)β. So α and β are ∓(x_cw ± x_ccw)/4L, and E_b = 90°/(90° − α),
//! R = (L/2)/sin(β/2), E_d = (R + b/2)/(R − b/2).
//!
//! Departures. α and β are the mean of what x and what y say, where the paper
//! reads them off x. And the paper's robot had a wheelbase of a twelfth of the
//! square's side; one that is a twenty-fifth of it is bent so far on a side (β
//! of 7° for wheels that differ by 0.5 %) that second order counts. So a second
//! estimate finds those E_b and E_d for which the exact arcs of
//! [`model`](super::model) end at the centres of gravity: four numbers, two
//! unknowns, least squares by Gauss and Newton, begun at the paper's estimate. Sides that
//! are bent by a radian have other minima; where the one that is found does not explain the
//! returns, the search begins at each factor of a grid, and what leaves the least is taken.
//! Standard errors come from how far the returns of each way scatter, carried
//! through the first derivatives.

use rusty_geometry::trig;
use serde::Serialize;

use super::factors::Factors;
use super::lap::{Return, Way};
use super::model::returned_m;
use rusty_metrics::Moments;

/// Steps of Gauss and Newton; three are enough for errors of some percent.
const STEPS: usize = 30;
/// Factors explain the returns if they leave at most this part of their distance, this part
/// of a side and this number of standard errors.
const EXPLAINED: f64 = 0.1;
const EXPLAINED_SIDE: f64 = 1e-3;
const EXPLAINED_STD: f64 = 5.0;
/// The grid of beginnings, in steps from 1: how many to each side, and how long.
const BEGIN_WHEELBASE: (i32, f64) = (4, 0.05);
const BEGIN_DIAMETERS: (i32, f64) = (20, 0.01);
/// Results of them are this far from 1 at most: many turns more end at the same place too.
const MOST_OFF: f64 = 0.25;
/// Step of a numerical derivative: of a factor near 1.
const STEP: f64 = 1e-6;

/// Centre of gravity of the returns of one way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Centre {
    /// Which way round.
    pub way: Way,
    /// x of the returns, m.
    pub x_m: Moments,
    /// y of the returns, m.
    pub y_m: Moments,
    /// Distance of the centre from the start, m.
    pub r_m: f64,
}

/// The two factors, with the standard error of each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimated {
    /// E_b and E_d.
    pub factors: Factors,
    /// Their standard errors; 0 where every lap ended in the same place.
    pub standard_errors: Factors,
}

/// What the laps say.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Clockwise, counter-clockwise.
    pub centres: [Centre; 2],
    /// E_max,syst: the larger distance of the two centres from the start, m.
    pub e_max_syst_m: f64,
    /// Type A: what every corner lacks, rad.
    pub alpha_rad: f64,
    /// Type B: how far every side is bent to the left, rad.
    pub beta_rad: f64,
    /// Standard error of either, rad.
    pub standard_error_rad: f64,
    /// By the formulas of the paper.
    pub paper: Estimated,
    /// By exact arcs.
    pub exact: Estimated,
}

/// Works out what the returns say, of laps around sides of `side_m` by a robot
/// that believes its wheelbase to be `track_m`.
#[must_use]
pub fn estimate(returns: &[Return], side_m: f64, track_m: f64) -> Estimate {
    let of = |way: Way| -> Vec<[f64; 2]> {
        returns.iter().filter(|r| r.way == way).map(|r| [r.x_m, r.y_m]).collect()
    };
    let places = Way::BOTH.map(of);
    let centres = [0, 1].map(|i| centre(Way::BOTH[i], &places[i]));
    // α and β by the sums x + y (cw) and x − y (ccw), in which they are whole.
    let sums = [(0, 1.0), (1, -1.0)].map(|(i, sign): (usize, f64)| {
        let sums: Vec<f64> = places[i].iter().map(|[x, y]| x + sign * y).collect();
        Moments::of(&sums)
    });
    let alpha_rad = (sums[0].mean + sums[1].mean) / (-8.0 * side_m);
    let beta_rad = (sums[0].mean - sums[1].mean) / (-8.0 * side_m);
    let variance = sums[0].variance_of_mean() + sums[1].variance_of_mean();
    let standard_error_rad = variance.sqrt() / (8.0 * side_m);
    let paper = by_the_paper(alpha_rad, beta_rad, standard_error_rad, side_m, track_m);
    Estimate {
        centres,
        e_max_syst_m: centres[0].r_m.max(centres[1].r_m),
        alpha_rad,
        beta_rad,
        standard_error_rad,
        paper,
        exact: by_exact_arcs(paper.factors, &centres, &places, side_m, track_m),
    }
}

fn centre(way: Way, places: &[[f64; 2]]) -> Centre {
    let of = |axis: usize| Moments::of(&places.iter().map(|p| p[axis]).collect::<Vec<f64>>());
    let (x_m, y_m) = (of(0), of(1));
    Centre { way, x_m, y_m, r_m: trig::hypot(x_m.mean, y_m.mean) }
}

fn by_the_paper(alpha: f64, beta: f64, error: f64, side_m: f64, track_m: f64) -> Estimated {
    let quarter = core::f64::consts::FRAC_PI_2;
    // (R + b/2)/(R − b/2), both times 2 sin(β/2): a straight side has no radius.
    let bend = track_m * trig::sin(0.5 * beta);
    let spare = side_m - bend;
    let factors =
        Factors { wheelbase: quarter / (quarter - alpha), diameters: (side_m + bend) / spare };
    let by_alpha = quarter / ((quarter - alpha) * (quarter - alpha));
    let by_beta = side_m * track_m * trig::cos(0.5 * beta) / (spare * spare);
    let standard_errors = Factors { wheelbase: by_alpha * error, diameters: by_beta * error };
    Estimated { factors, standard_errors }
}

fn by_exact_arcs(
    begin: Factors,
    centres: &[Centre; 2],
    places: &[Vec<[f64; 2]>; 2],
    side_m: f64,
    track_m: f64,
) -> Estimated {
    let ends = |f: &Factors| -> [f64; 4] {
        let [a, b] = Way::BOTH.map(|way| returned_m(f, side_m, track_m, way));
        [a[0], a[1], b[0], b[1]]
    };
    let [a, b] = centres;
    let along = [a.x_m, a.y_m, b.x_m, b.y_m];
    let centres = along.map(|place| place.mean);
    let left = |factors: &Factors| {
        let here = ends(factors);
        (0..4).map(|k| (centres[k] - here[k]) * (centres[k] - here[k])).sum::<f64>()
    };
    let solved = |begin: Factors| {
        let (mut factors, mut inverse) = (begin, [[0.0; 4]; 2]);
        for _ in 0..STEPS {
            inverse = pseudo_inverse(&ends, &factors);
            let here = ends(&factors);
            let step =
                inverse.map(|row| (0..4).map(|k| row[k] * (centres[k] - here[k])).sum::<f64>());
            factors.wheelbase += step[0];
            factors.diameters += step[1];
            if step[0].abs() + step[1].abs() < 1e-14 {
                break;
            }
        }
        (left(&factors), factors, inverse)
    };
    let mut best = solved(begin);
    let variance: f64 = along.iter().map(Moments::variance_of_mean).sum();
    let far = centres.iter().map(|c| c * c).sum::<f64>().sqrt();
    let most_m = EXPLAINED * far + EXPLAINED_SIDE * side_m + EXPLAINED_STD * variance.sqrt();
    let is_explained = best.0.sqrt() <= most_m;
    if !is_explained {
        let is_sane =
            |f: &Factors| [f.wheelbase, f.diameters].iter().all(|v| (v - 1.0).abs() <= MOST_OFF);
        let others = beginnings().map(solved).filter(|(_, factors, _)| is_sane(factors));
        best = others.chain([best]).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or(best);
    }
    let (_, factors, inverse) = best;
    // A return moves each factor by its row of the inverse; the two ways are
    // independent of each other.
    let error = |row: [f64; 4]| {
        let of = |i: usize| {
            let moved = places[i].iter().map(|[x, y]| row[2 * i] * x + row[2 * i + 1] * y);
            Moments::of(&moved.collect::<Vec<f64>>()).variance_of_mean()
        };
        (of(0) + of(1)).sqrt()
    };
    let [wheelbase, diameters] = inverse.map(error);
    Estimated { factors, standard_errors: Factors { wheelbase, diameters } }
}

/// The grid of beginnings.
fn beginnings() -> impl Iterator<Item = Factors> {
    let axis = |(count, step): (i32, f64)| (-count..=count).map(move |k| 1.0 + step * f64::from(k));
    axis(BEGIN_WHEELBASE).flat_map(move |wheelbase| {
        axis(BEGIN_DIAMETERS).map(move |diameters| Factors { wheelbase, diameters })
    })
}

/// (JᵀJ)⁻¹Jᵀ of the ends by the two factors, by central differences.
fn pseudo_inverse(ends: &dyn Fn(&Factors) -> [f64; 4], at: &Factors) -> [[f64; 4]; 2] {
    let moved = |wheelbase: f64, diameters: f64| {
        ends(&Factors { wheelbase: at.wheelbase + wheelbase, diameters: at.diameters + diameters })
    };
    let slope = |more: [f64; 4], less: [f64; 4]| -> [f64; 4] {
        [0, 1, 2, 3].map(|k| (more[k] - less[k]) / (2.0 * STEP))
    };
    let b = slope(moved(STEP, 0.0), moved(-STEP, 0.0));
    let d = slope(moved(0.0, STEP), moved(0.0, -STEP));
    let dot = |u: &[f64; 4], v: &[f64; 4]| u.iter().zip(v).map(|(u, v)| u * v).sum::<f64>();
    let (bb, bd, dd) = (dot(&b, &b), dot(&b, &d), dot(&d, &d));
    let determinant = bb * dd - bd * bd;
    [
        [0, 1, 2, 3].map(|k| (dd * b[k] - bd * d[k]) / determinant),
        [0, 1, 2, 3].map(|k| (bb * d[k] - bd * b[k]) / determinant),
    ]
}
