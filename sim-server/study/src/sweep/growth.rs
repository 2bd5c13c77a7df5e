//! The spread of a sweep's errors as the robot drives on, and the power of the distance
//! with which it grows. docs/metrics.md explains frames, exponents and sources.
//!
//! White slip gives the heading a random walk: exponent 0.5, and in log coordinates the
//! same along a straight track. Across it the heading error is summed once more: the
//! variance is proportional to Σ (n − j)² ≈ n³/3, exponent 1.5.
//!
//! The line is fitted to the logarithms from [`FIT_FROM`] of the way on. Its points are
//! the same runs, farther on, and not independent. So the exponent's standard error is
//! that of the jackknife over groups of seeds (B. Efron, *The Jackknife, the Bootstrap
//! and Other Resampling Plans*, 1982).

use std::collections::BTreeMap;
use std::fmt;

use rusty_geometry::{SE2, trig};
use serde::Serialize;

use super::lines::in_order;
use super::{Sample, Track};
use rusty_metrics::{Moments, PowerLaw};

/// The part of the way that is left out of the fit: one sixth, that is half a
/// second of the three in the chapter's laboratory.
pub const FIT_FROM: f64 = 1.0 / 6.0;
/// Most groups of seeds for the jackknife.
const GROUPS: usize = 20;
/// A spread below this is rounding, m or rad.
const LEAST_SPREAD: f64 = 1e-9;

/// The spread of an estimator's errors in a cell, sample by sample.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Growth {
    /// Index of the cell.
    pub cell: usize,
    /// Name in the roster.
    pub estimator: String,
    /// In order of time.
    pub samples: Vec<Spread>,
    /// The power of the distance with which each spread grows; `None` where
    /// there is none to speak of, or fewer than three samples.
    pub exponents: Exponents,
}

/// The errors of all seeds at one sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Time of the sample, s.
    pub time_s: f64,
    /// Distance truly driven up to then, mean over the seeds, m.
    pub distance_m: f64,
    /// Distance between estimate and truth, mean over the seeds, m.
    pub mean_error_m: f64,
    /// World frame: position error along the mean believed heading, m.
    pub along_m: Moments,
    /// World frame: position error across it, positive to the left, m.
    pub across_m: Moments,
    /// Spread of the position: √(var x + var y), m.
    pub position_m: f64,
    /// Spread across over spread along, world frame; NaN where nothing spreads along.
    pub across_over_along: f64,
    /// Log coordinates: error along the track, m.
    pub log_along_m: Moments,
    /// Log coordinates: error across the track, positive to the left, m.
    pub log_across_m: Moments,
    /// Heading error, rad.
    pub heading_rad: Moments,
}

/// The fitted exponent of each spread against distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Exponents {
    /// Of the position.
    pub position: Option<Exponent>,
    /// Along the track, log coordinates.
    pub log_along: Option<Exponent>,
    /// Across the track, log coordinates.
    pub log_across: Option<Exponent>,
    /// Of the heading.
    pub heading: Option<Exponent>,
}

/// An exponent, and how far it is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Exponent {
    /// The line; x is a distance in m, y m or rad.
    pub law: PowerLaw,
    /// Standard error of its exponent, by the jackknife over seeds; NaN with
    /// fewer than three seeds.
    pub standard_error: f64,
}

impl fmt::Display for Exponent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.2}", self.law.exponent)?;
        if self.standard_error.is_finite() {
            write!(f, " ± {:.2}", self.standard_error)?;
        }
        Ok(())
    }
}

/// Which standard deviation.
type Which = fn(&Spread) -> f64;

const POSITION: Which = |s| s.position_m;
const ALONG: Which = |s| s.log_along_m.standard_deviation;
const ACROSS: Which = |s| s.log_across_m.standard_deviation;
const HEADING: Which = |s| s.heading_rad.standard_deviation;

/// The growth of every estimator in every cell, in the order in which they come
/// in `tracks`. A track that lacks a sample is left out there.
#[must_use]
pub fn growth(tracks: &[Track]) -> Vec<Growth> {
    in_order(tracks.iter().map(|track| (track.cell, &*track.estimator)))
        .into_iter()
        .map(|(cell, estimator)| {
            let is_it = |t: &&Track| t.cell == cell && *t.estimator == *estimator;
            let own: Vec<&Track> = tracks.iter().filter(is_it).collect();
            let samples = spreads(&own);
            let exponents = exponents(&own, &samples);
            Growth { cell, estimator: estimator.to_owned(), samples, exponents }
        })
        .collect()
}

fn spreads(tracks: &[&Track]) -> Vec<Spread> {
    // By time, whose bits are in the order of the numbers, as none is negative.
    let mut by_time: BTreeMap<u64, Vec<&Sample>> = BTreeMap::new();
    for sample in tracks.iter().flat_map(|t| &t.samples) {
        by_time.entry(sample.time_s.abs().to_bits()).or_default().push(sample);
    }
    by_time.values().filter_map(|samples| spread(samples)).collect()
}

/// Of samples of one time.
fn spread(samples: &[&Sample]) -> Option<Spread> {
    let of = |what: fn(&Sample) -> f64| {
        let all: Vec<f64> = samples.iter().map(|s| what(s)).collect();
        Moments::of(&all)
    };
    let [along_m, across_m] = world_frame(samples);
    let (along, across) = (along_m.standard_deviation, across_m.standard_deviation);
    Some(Spread {
        time_s: samples.first()?.time_s,
        distance_m: of(|s| s.distance_m).mean,
        mean_error_m: of(|s| (s.estimate.translation() - s.truth.translation()).norm()).mean,
        along_m,
        across_m,
        position_m: (along * along + across * across).sqrt(),
        across_over_along: if along > LEAST_SPREAD { across / along } else { f64::NAN },
        log_along_m: of(|s| s.estimate.boxminus(&s.truth).x),
        log_across_m: of(|s| s.estimate.boxminus(&s.truth).y),
        heading_rad: of(|s| s.estimate.boxminus(&s.truth).z),
    })
}

/// Position errors along and across the mean of the believed headings.
fn world_frame(samples: &[&Sample]) -> [Moments; 2] {
    let (sin, cos) = samples.iter().fold((0.0, 0.0), |(sin, cos), s| {
        let (s, c) = trig::sin_cos(s.estimate.theta());
        (sin + s, cos + c)
    });
    let track = SE2::new(0.0, 0.0, trig::atan2(sin, cos)).inverse();
    let errors: Vec<_> = samples
        .iter()
        .map(|s| s.estimate.translation() - s.truth.translation())
        .map(|error| track.transform_point(&error.into()))
        .collect();
    let axis = |k: usize| Moments::of(&errors.iter().map(|e| e[k]).collect::<Vec<f64>>());
    [axis(0), axis(1)]
}

fn exponents(tracks: &[&Track], samples: &[Spread]) -> Exponents {
    // The spreads with each group of seeds left out in turn.
    let groups = tracks.len().min(GROUPS);
    let without: Vec<Vec<Spread>> = (0..groups)
        .map(|group| {
            let rest: Vec<&Track> =
                (0..tracks.len()).filter(|k| k % groups != group).map(|k| tracks[k]).collect();
            spreads(&rest)
        })
        .collect();
    let exponent = |which: Which| {
        let law = fit(samples, which)?;
        let standard_error = jackknife(&without, which);
        Some(Exponent { law, standard_error })
    };
    Exponents {
        position: exponent(POSITION),
        log_along: exponent(ALONG),
        log_across: exponent(ACROSS),
        heading: exponent(HEADING),
    }
}

fn fit(samples: &[Spread], which: Which) -> Option<PowerLaw> {
    let last = samples.last()?;
    let end = which(last);
    if end.is_nan() || end <= LEAST_SPREAD {
        return None;
    }
    let points: Vec<[f64; 2]> = samples.iter().map(|s| [s.distance_m, which(s)]).collect();
    // A hair below, so that a sample exactly there is in.
    PowerLaw::fit(&points, FIT_FROM * last.distance_m * (1.0 - 1e-9))
}

/// √((g − 1)/g · Σ (pᵢ − p̄)²) over the g exponents without a group each.
fn jackknife(without: &[Vec<Spread>], which: Which) -> f64 {
    let exponents: Vec<f64> =
        without.iter().filter_map(|s| fit(s, which)).map(|law| law.exponent).collect();
    let g = exponents.len() as f64;
    if exponents.len() < 3 || exponents.len() < without.len() {
        return f64::NAN;
    }
    (g - 1.0) / g.sqrt() * Moments::of(&exponents).standard_deviation
}

#[cfg(test)]
#[path = "growth_tests.rs"]
mod tests;
