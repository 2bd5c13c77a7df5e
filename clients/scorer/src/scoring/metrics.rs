//! How far the estimates are from the truth.
//!
//! A [`Meter`] sees the ticks of a run one by one and keeps sums: it takes the
//! same memory for any number of them, but for percentiles and medians
//! ([`quantile`](rusty_contract::score::quantile) says how those are kept). What
//! is measured lies in files of its own: `trajectory` (ATE and RPE), `alignment`,
//! `consistency` (NEES and NIS, with `batches`), `convergence`, `compute`.
//!
//! Source: M. Grupp, *evo* (Python package, 1.38.1), and those that the other
//! files name; docs/metrics.md explains each figure.
//!
//! Departures: poses are planar; and where evo pairs time stamps, a tick here is
//! scored when it has both a true and an estimated pose made of numbers.
//! Everything else (a recording's ticks between two scans, say) is passed over,
//! and a pair of the relative error is two scored ticks with none between.

use rusty_contract::score::{Alignment, Errors, PathLength, Score};
use rusty_contract::{Estimate, Innovation};
use rusty_geometry::SE2;

use super::alignment::aligned_errors;
use super::compute::Times;
use super::consistency::{Samples, nees};
use super::convergence::Search;
use super::scored::Scored;
use super::trace::RunTrace;
use super::trajectory::{Absolute, METRE, Relative};
use super::yardstick::Yardstick;
use rusty_clients::witness::Delay;

/// The shortest way of which an error can be a share, m: that of a step of the
/// relative error. Of less, rounding and the first error make any percentage.
const LEAST_DRIVEN_M: f64 = METRE;

/// One score per estimator, in roster order. A figure is `None` where nothing
/// was scored that it could be made of: all of them without a scored tick, the
/// relative ones with a single one, the drift where it is not one of driving.
/// A trace knows no innovations and durations, nor the covariances of all ticks,
/// so what is made of those is `None`, too.
#[must_use]
pub fn score(trace: &RunTrace) -> Vec<Score> {
    let planned = Planned {
        ticks: trace.ticks() as u64,
        start: trace.start,
        kidnapped_at: trace.kidnapped_at.clone(),
        // What has no seed has stamps of its own.
        began_s: trace.seed.map(|_| 0.0),
    };
    let mut meter = Meter::new(&trace.names, &planned, Yardstick::default());
    for tick in 0..trace.ticks() {
        let given =
            |i| Given { estimate: trace.estimate(i, tick).map(Into::into), ..Given::default() };
        let moment =
            Moment { tick: tick as u64, time_s: trace.time_s[tick], truth: trace.true_pose(tick) };
        meter.push(&moment, (0..trace.names.len()).map(given));
    }
    meter.scores(trace)
}

/// What is known of a run before its first tick.
#[derive(Clone, Debug, Default)]
pub struct Planned {
    /// How many ticks are to come.
    pub ticks: u64,
    /// The true pose before the first tick, where known.
    pub start: Option<SE2>,
    /// Ticks at whose start the robot is put elsewhere.
    pub kidnapped_at: Vec<u64>,
    /// When the run began, s; `None`: with its first tick.
    pub began_s: Option<f64>,
}

/// A tick, as far as it is the same for all estimators.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Its number in the run.
    pub tick: u64,
    /// When it ends, s.
    pub time_s: f64,
    /// The true pose, world frame, where known.
    pub truth: Option<SE2>,
}

/// What an estimator gave at a tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct Given {
    /// The estimate in effect.
    pub estimate: Option<Estimate>,
    /// The innovation in the answer to this tick: what a filter saw is counted
    /// when it says so, once, however late its estimate takes effect.
    pub innovation: Option<Innovation>,
    /// How long the answer to this tick took.
    pub delay: Option<Delay>,
}

/// What is measured of a run, tick by tick.
#[derive(Clone, Debug)]
pub struct Meter {
    ticks: u64,
    ticks_with_truth: u64,
    driven: PathLength,
    estimators: Vec<Sums>,
}

/// What is kept of one estimator.
#[derive(Clone, Debug)]
struct Sums {
    name: String,
    /// Ticks with an estimate.
    given: u64,
    errors: Errors,
    absolute: Absolute,
    relative: Relative,
    pairs: u64,
    relative_m2: f64,
    relative_deg2: f64,
    nees: Samples,
    nis: Samples,
    search: Search,
    times: Times,
}

impl Meter {
    /// A run of which no tick has been seen. Seeing as many as are planned
    /// allocates nothing.
    #[must_use]
    pub fn new(names: &[String], planned: &Planned, yardstick: Yardstick) -> Self {
        let ticks = planned.ticks;
        let sums = |name: &String| Sums {
            name: name.clone(),
            given: 0,
            errors: Errors::expecting(ticks),
            absolute: Absolute::expecting(ticks),
            relative: Relative::expecting(ticks),
            pairs: 0,
            relative_m2: 0.0,
            relative_deg2: 0.0,
            nees: Samples::of_errors(yardstick.level),
            nis: Samples::of_innovations(yardstick.level),
            search: Search::new(yardstick.within, &planned.kidnapped_at, planned.began_s),
            times: Times::expecting(ticks),
        };
        let estimators = names.iter().map(sums).collect();
        let driven = PathLength::new(planned.start, planned.kidnapped_at.clone());
        Self { ticks: 0, ticks_with_truth: 0, driven, estimators }
    }

    /// Adds a tick. `given` comes in the order of the names; what is missing at
    /// the end counts as not given, and more of it than names is left aside. So
    /// are poses that are no numbers.
    pub fn push(&mut self, moment: &Moment, given: impl Iterator<Item = Given>) {
        self.ticks += 1;
        let truth = moment.truth.filter(SE2::is_finite);
        if let Some(pose) = truth {
            self.ticks_with_truth += 1;
            self.driven.push(moment.tick, &pose);
        }
        let given = given.chain(std::iter::repeat_with(Given::default));
        for (sums, given) in self.estimators.iter_mut().zip(given) {
            sums.push(&Moment { truth, ..*moment }, &given);
        }
    }

    /// Ticks seen.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.ticks
    }

    /// Those of them that have a true pose.
    #[must_use]
    pub fn ticks_with_truth(&self) -> u64 {
        self.ticks_with_truth
    }

    /// Distance truly driven, m; see [`distance_driven_m`](super::trace::distance_driven_m).
    #[must_use]
    pub fn driven_m(&self) -> f64 {
        self.driven.metres()
    }

    /// One score per estimator, in the order of the names; see [`score()`].
    /// `kept` are the ticks that are left for what needs all of them at once,
    /// which is laying an estimate over the truth.
    #[must_use]
    pub fn scores(&mut self, kept: &RunTrace) -> Vec<Score> {
        let (ticks, driven_m) = (self.ticks, self.driven.metres());
        let kidnapped = kept.kidnapped_at.iter().any(|tick| *tick < ticks);
        let score = |(i, sums): (usize, &mut Sums)| {
            let mut score = sums.score(ticks, driven_m);
            score.told = kept.told.get(i).copied().unwrap_or_default();
            score.alignment = score.told.alignment();
            if let Some((errors, figures)) = aligned_errors(kept, i) {
                (score.ate.se2, score.aligned) = (Some(errors), figures);
            }
            let by_driving = score.alignment == Alignment::None && !kidnapped;
            score.drift_percent = score
                .final_position_error_m
                .filter(|_| by_driving && driven_m >= LEAST_DRIVEN_M)
                .map(|error_m| 100.0 * error_m / driven_m);
            score
        };
        self.estimators.iter_mut().enumerate().map(score).collect()
    }
}

impl Sums {
    fn push(&mut self, moment: &Moment, given: &Given) {
        self.search.begin(moment.tick, moment.time_s);
        if let Some(Innovation { nis, degrees }) = given.innovation {
            self.nis.push(Some(nis), degrees);
        }
        if let Some(delay) = given.delay {
            self.times.push(delay);
        }
        let estimate = given.estimate.filter(|e| e.pose_in_world.is_finite());
        self.given += u64::from(estimate.is_some());
        let (truth, estimate) = match (moment.truth, estimate) {
            (Some(truth), Some(estimate)) => (truth, estimate),
            (Some(_), None) => return self.search.silent(),
            (None, _) => return,
        };
        let pose = estimate.pose_in_world;
        self.score_tick(&Scored { tick: moment.tick as usize, truth, estimate: pose });
        if let Some(covariance) = &estimate.covariance {
            self.nees.push(nees(&truth, &pose, covariance), 3);
        }
    }

    fn score_tick(&mut self, scored: &Scored) {
        self.errors.push(&scored.estimate, &scored.truth);
        self.search.push(scored);
        self.absolute.push(scored);
        if let Some((error_m, error_rad)) = self.relative.push(scored) {
            let error_deg = error_rad.to_degrees();
            self.pairs += 1;
            self.relative_m2 += error_m * error_m;
            self.relative_deg2 += error_deg * error_deg;
        }
    }

    fn score(&mut self, ticks: u64, driven_m: f64) -> Score {
        let figures = self.errors.figures();
        Score {
            name: self.name.clone(),
            scored_ticks: self.errors.ticks(),
            unscored_ticks: ticks - self.given,
            final_position_error_m: figures.final_position_error_m,
            final_heading_error_deg: figures.final_heading_error_rad.map(f64::to_degrees),
            final_heading_error_rad: figures.final_heading_error_rad,
            mean_position_error_m: figures.mean_position_error_m,
            p95_position_error_m: figures.p95_position_error_m,
            max_position_error_m: figures.max_position_error_m,
            rmse_heading_error_rad: figures.rmse_heading_error_rad,
            max_heading_error_rad: figures.max_heading_error_rad,
            ate_rmse_m: figures.ate_rmse_m,
            rpe_rmse_m: root_mean(self.relative_m2, self.pairs),
            rpe_rmse_deg: root_mean(self.relative_deg2, self.pairs),
            distance_m: driven_m,
            ate: self.absolute.errors(&mut self.errors),
            rpe: self.relative.errors(),
            nees: self.nees.consistency(),
            nis: self.nis.consistency(),
            convergence: self.search.convergence(),
            compute: self.times.figures(),
            ..Score::default()
        }
    }
}

fn root_mean(sum: f64, count: u64) -> Option<f64> {
    (count > 0).then(|| (sum / count as f64).sqrt())
}

#[cfg(test)]
#[path = "metrics_tests.rs"]
mod tests;

#[cfg(test)]
#[path = "evo_tests.rs"]
mod evo_tests;
