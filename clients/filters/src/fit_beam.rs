//! Learning the intrinsic parameters of the beam model by expectation
//! maximisation.
//!
//! Source: *Probabilistic Robotics*, §6.3.2, Table 6.2
//! (`learn_intrinsic_parameters`): who is responsible for a reading is asked of
//! the model ([`BeamModel::responsibilities`]), and the model is fitted to what
//! they say, in turn, until nothing changes. The likelihood never falls.
//!
//! Departures, and why:
//! * λ of *short* is where its expected log likelihood is greatest with the law
//!   cut off at z*, as the model has it. The book's Σe / Σe·z is that of a law
//!   without an end, which lets the likelihood fall; it is where the search starts.
//! * σ of *hit* is where its expected log likelihood is greatest with the law cut
//!   off at 0 and z_max (the η of equation 6.6), as the model has it. The book's
//!   √(Σe·r² / Σe) is that of a law without ends. Where walls are about z_max away it
//!   goes too far or not far enough, and where it stops depends on where it began.
//! * Each number has its standard error, from the observed information:
//!   the sum of the outer products of the readings' scores (I. Meilijson, *A Fast
//!   Improvement to the EM Algorithm on its Own Terms*, JRSS B 51, 1989). The
//!   weights add up to 1, so that of *hit* follows from the others.
//! * A number that no reading depends on has no error, and none is made up: with
//!   nothing in front of the walls there is no λ.

mod readings;
mod recorder;

use nalgebra::{SMatrix, SVector};
use rusty_geometry::trig;
use serde::Serialize;

pub use readings::{Expected, Reading, Readings};
pub use recorder::{FitBeam, Options};

use crate::BeamModel;
use crate::beam_model::Parts;

/// A weight below this is none: in a hundred million readings there would be one.
const NO_WEIGHT: f64 = 1e-8;
/// λ is looked for between this and its inverse, 1/m.
const LEAST_LAMBDA: f64 = 1e-3;
/// σ is looked for from this on, m,
const LEAST_SIGMA_M: f64 = 1e-5;
/// and up to this many z_max: a law as wide as that is flat.
const MOST_SIGMA: f64 = 10.0;

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criterion {
    /// Once the mean log likelihood of a reading rises by less than this.
    pub tolerance: f64,
    /// Maximum number of rounds.
    pub rounds: usize,
}

impl Default for Criterion {
    fn default() -> Self {
        Self { tolerance: 1e-10, rounds: 1000 }
    }
}

/// One round of the fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Round {
    /// Mean log likelihood of a reading under the numbers of this round.
    pub log_likelihood: f64,
    /// Weights of hit, short, max and rand.
    pub weights: [f64; 4],
    /// σ of hit, m.
    pub sigma_hit_m: f64,
    /// λ of short, 1/m.
    pub lambda_short_per_m: f64,
}

impl Round {
    fn new(model: &BeamModel, log_likelihood: f64) -> Self {
        Self {
            log_likelihood,
            weights: [model.z_hit, model.z_short, model.z_max, model.z_rand],
            sigma_hit_m: model.sigma_hit_m,
            lambda_short_per_m: model.lambda_short_per_m,
        }
    }
}

/// A number and how sure it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fitted {
    /// The number.
    pub value: f64,
    /// Its standard error; `None` where the readings do not depend on it.
    pub std_error: Option<f64>,
}

/// The result of a fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BeamFit {
    /// Weight of readings of what the map has.
    pub z_hit: Fitted,
    /// Weight of readings of something in front of it.
    pub z_short: Fitted,
    /// Weight of readings of nothing.
    pub z_max: Fitted,
    /// Weight of readings of anything.
    pub z_rand: Fitted,
    /// σ of hit, m.
    pub sigma_hit_m: Fitted,
    /// λ of short, 1/m.
    pub lambda_short_per_m: Fitted,
    /// How many readings were fitted to.
    pub readings: usize,
    /// Whether it stopped because nothing changed any more.
    pub converged: bool,
    /// Every round, the first guess included.
    pub rounds: Vec<Round>,
}

/// What a round adds up over all readings.
#[derive(Clone, Copy, Default)]
struct Sums {
    log_likelihood: f64,
    count: [f64; 4],
    /// Squares of the errors of readings below z_max that were hits, m².
    squares_m2: f64,
}

/// Readings that may have come about in these ways: how likely it is, and where.
#[derive(Default)]
struct Causes {
    /// By something in front of the map: e, the range and z*, m.
    shorts: Vec<[f64; 3]>,
    /// By what the map has, below z_max: e and z*, m.
    hits: Vec<[f64; 2]>,
}

/// Fits the model to the readings, beginning with `guess`; `None` if there is no
/// reading.
pub fn fit(readings: &Readings, guess: BeamModel, criterion: Criterion) -> Option<BeamFit> {
    if readings.all.is_empty() {
        return None;
    }
    let count = readings.all.len() as f64;
    let mut model = guess;
    let mut rounds: Vec<Round> = Vec::new();
    let mut causes = Causes::default();
    let converged = loop {
        let mut sums = expect(readings, &model, &mut causes);
        let before = rounds.last().map(|r| r.log_likelihood);
        // The mass of a hit is known to seven digits. Where the last ones of σ make
        // the likelihood fall: half as far, until it is no step down.
        while let Some(last) =
            rounds.last().filter(|l| sums.log_likelihood < l.log_likelihood * count)
        {
            let change_m = model.sigma_hit_m - last.sigma_hit_m;
            if change_m.abs() <= 1e-12 * last.sigma_hit_m {
                break;
            }
            model.sigma_hit_m = last.sigma_hit_m + 0.5 * change_m;
            sums = expect(readings, &model, &mut causes);
        }
        let log_likelihood = sums.log_likelihood / count;
        rounds.push(Round::new(&model, log_likelihood));
        let converged = before.is_some_and(|b| log_likelihood - b < criterion.tolerance);
        // What is answered is the model of the last round.
        if converged || rounds.len() > criterion.rounds {
            break converged;
        }
        model = maximise(&model, &sums, &causes, readings.range_max_m);
    };
    let errors = standard_errors(readings, &model);
    let fitted = |value, place: usize| Fitted { value, std_error: errors[place] };
    Some(BeamFit {
        z_hit: fitted(model.z_hit, 5),
        z_short: fitted(model.z_short, 0),
        z_max: fitted(model.z_max, 1),
        z_rand: fitted(model.z_rand, 2),
        sigma_hit_m: fitted(model.sigma_hit_m, 3),
        lambda_short_per_m: fitted(model.lambda_short_per_m, 4),
        readings: readings.all.len(),
        converged,
        rounds,
    })
}

/// Who is responsible for each reading: the sums of Table 6.2, and the readings
/// that the parts with a shape may be responsible for.
fn expect(readings: &Readings, model: &BeamModel, causes: &mut Causes) -> Sums {
    let mut sums = Sums::default();
    causes.shorts.clear();
    causes.hits.clear();
    for Reading { range_m, expected_m } in &readings.all {
        let density = model.density(*range_m, *expected_m, readings.range_max_m);
        let e = model.responsibilities(*range_m, *expected_m, readings.range_max_m);
        // What nothing explains would make all others worthless.
        sums.log_likelihood += trig::ln(density.max(f64::MIN_POSITIVE));
        for (sum, e) in sums.count.iter_mut().zip([e.hit, e.short, e.max, e.rand]) {
            *sum += e;
        }
        // A reading of z_max where nothing was expected has no error.
        if *range_m < readings.range_max_m && e.hit > NO_WEIGHT {
            let error_m = range_m - expected_m;
            sums.squares_m2 += e.hit * error_m * error_m;
            causes.hits.push([e.hit, *expected_m]);
        }
        if e.short > NO_WEIGHT {
            causes.shorts.push([e.short, *range_m, expected_m.min(readings.range_max_m)]);
        }
    }
    sums
}

/// The numbers under which what [`expect`] said is most likely.
fn maximise(model: &BeamModel, sums: &Sums, causes: &Causes, range_max_m: f64) -> BeamModel {
    let all: f64 = sums.count.iter().sum();
    if all <= 0.0 {
        return *model;
    }
    let [z_hit, z_short, z_max, z_rand] = sums.count.map(|n| n / all);
    let sigma_hit_m =
        most_likely_sigma_m(model.sigma_hit_m, sums.squares_m2, &causes.hits, range_max_m);
    let lambda_short_per_m = most_likely_lambda(model.lambda_short_per_m, &causes.shorts);
    BeamModel { z_hit, z_short, z_max, z_rand, sigma_hit_m, lambda_short_per_m }
}

/// σ where Σ e ln N(z; z*, σ) / η is greatest: where the squares of the errors are
/// together what such a law has on average. That grows with σ; the book's step,
/// towards the σ that would have them if the law were as far from its ends as it is
/// now, is kept between the bounds that are known.
fn most_likely_sigma_m(sigma_m: f64, squares_m2: f64, hits: &[[f64; 2]], range_max_m: f64) -> f64 {
    if hits.is_empty() {
        return sigma_m;
    }
    let squares_at = |sigma_m: f64| -> f64 {
        let of = |[e, expected_m]: &[f64; 2]| {
            e * BeamModel::hit_second_moment(sigma_m, *expected_m, range_max_m)
        };
        sigma_m * sigma_m * hits.iter().map(of).sum::<f64>()
    };
    let (mut low_m, mut high_m) = (LEAST_SIGMA_M, MOST_SIGMA * range_max_m);
    if squares_at(low_m) >= squares_m2 {
        return low_m;
    }
    if squares_at(high_m) <= squares_m2 {
        return high_m;
    }
    let mut sigma_m = sigma_m.clamp(low_m, high_m);
    for _ in 0..200 {
        let there_m2 = squares_at(sigma_m);
        if there_m2 < squares_m2 {
            low_m = sigma_m;
        } else {
            high_m = sigma_m;
        }
        let book_m = sigma_m * (squares_m2 / there_m2).sqrt();
        let is_inside = book_m > low_m && book_m < high_m;
        let next_m = if is_inside { book_m } else { (low_m * high_m).sqrt() };
        if (next_m - sigma_m).abs() <= 1e-9 * sigma_m {
            return next_m;
        }
        sigma_m = next_m;
    }
    sigma_m
}

/// z* / (exp(λ z*) − 1): what cutting the exponential law off at z* takes from
/// the mean of a range.
fn cut_m(lambda: f64, expected_m: f64) -> f64 {
    let x = lambda * expected_m;
    // Below that the difference loses its digits; this is its series.
    if x < 1e-5 { (1.0 - 0.5 * x) / lambda } else { expected_m / (trig::exp(x) - 1.0) }
}

/// λ where Σ e (ln λ − λ z − ln(1 − exp(−λ z*))) is greatest. That is concave, so
/// its slope has one zero; Newton's steps are kept between the bounds that are
/// known of it.
fn most_likely_lambda(lambda: f64, shorts: &[[f64; 3]]) -> f64 {
    let slope = |lambda: f64| {
        let mut sums = (0.0, 0.0);
        for [e, range_m, expected_m] in shorts {
            let cut_m = cut_m(lambda, *expected_m);
            sums.0 += e * (1.0 / lambda - range_m - cut_m);
            sums.1 += e * (cut_m * (cut_m + expected_m) - 1.0 / (lambda * lambda));
        }
        sums
    };
    let (mut low, mut high) = (LEAST_LAMBDA, 1.0 / LEAST_LAMBDA);
    if shorts.is_empty() || slope(high).0 >= 0.0 {
        return if shorts.is_empty() { lambda } else { high };
    }
    if slope(low).0 <= 0.0 {
        return low;
    }
    let mut lambda = lambda.clamp(low, high);
    for _ in 0..60 {
        let (first, second) = slope(lambda);
        if first > 0.0 {
            low = lambda
        } else {
            high = lambda
        }
        let newton = lambda - first / second;
        let is_inside = newton > low && newton < high;
        let next = if is_inside { newton } else { (low * high).sqrt() };
        if (next - lambda).abs() <= 1e-12 * lambda {
            return next;
        }
        lambda = next;
    }
    lambda
}

/// Standard errors of z_short, z_max, z_rand, σ, λ and z_hit, in this order.
fn standard_errors(readings: &Readings, model: &BeamModel) -> [Option<f64>; 6] {
    let (mut information, mut slope) = (SMatrix::<f64, 5, 5>::zeros(), SVector::<f64, 5>::zeros());
    for reading in &readings.all {
        if let Some(score) = score(reading, model, readings.range_max_m) {
            information += score * score.transpose();
            slope += score;
        }
    }
    let count = readings.all.len() as f64;
    let weights = [model.z_short, model.z_max, model.z_rand];
    // Less than one reading: no stationary point, but the edge of what is possible.
    let at_edge = weights.map(|weight| weight * count < 1.0);
    let mut is_silent = [at_edge[0], at_edge[1], at_edge[2], model.z_hit * count < 1.0, at_edge[0]];
    for (i, silent) in is_silent.iter_mut().enumerate() {
        *silent = *silent || information[(i, i)] <= 0.0;
    }
    for i in (0..5).filter(|i| is_silent[*i]) {
        for k in 0..5 {
            information[(i, k)] = 0.0;
            information[(k, i)] = 0.0;
        }
        information[(i, i)] = 1.0;
    }
    let mut errors = [None; 6];
    let Some(covariance) = information.cholesky().map(|c| c.inverse()) else { return errors };
    for i in (0..5).filter(|i| !is_silent[*i]) {
        errors[i] = Some(covariance[(i, i)].sqrt());
    }
    // There the likelihood falls as exp(−slope · weight): as wide as that law is.
    for i in (0..3).filter(|i| at_edge[*i] && slope[*i] < 0.0) {
        errors[i] = Some(-1.0 / slope[i]);
    }
    let free: Vec<usize> = (0..3).filter(|i| !at_edge[*i]).collect();
    let pairs = free.iter().flat_map(|i| free.iter().map(move |k| (*i, *k)));
    errors[5] = Some(pairs.map(|pair| covariance[pair]).sum::<f64>().max(0.0).sqrt());
    errors
}

/// Slopes of a reading's log likelihood in z_short, z_max, z_rand (each at the
/// cost of z_hit), σ and λ; `None` if nothing explains it.
fn score(reading: &Reading, model: &BeamModel, range_max_m: f64) -> Option<SVector<f64, 5>> {
    let Reading { range_m, expected_m } = *reading;
    let density = model.density(range_m, expected_m, range_max_m);
    if density <= 0.0 {
        return None;
    }
    let Parts { hit, short, max, rand } = model.parts(range_m, expected_m, range_max_m);
    let (sigma_m, lambda) = (model.sigma_hit_m, model.lambda_short_per_m);
    let error_m = range_m - expected_m;
    let by_sigma = if range_m < range_max_m {
        // Of the normal law, and of its mass between 0 and z_max.
        let moment = BeamModel::hit_second_moment(sigma_m, expected_m, range_max_m);
        model.z_hit * hit * (error_m * error_m / (sigma_m * sigma_m) - moment) / sigma_m
    } else {
        0.0
    };
    let nearest_m = expected_m.min(range_max_m);
    let by_lambda = model.z_short * short * (1.0 / lambda - range_m - cut_m(lambda, nearest_m));
    Some(SVector::from([short - hit, max - hit, rand - hit, by_sigma, by_lambda]) / density)
}

#[cfg(test)]
mod tests;
