//! [`Meter`]: all figures of a run.
//!
//! It sees the ticks one by one and keeps sums: it takes the same memory for any
//! number of them, but for percentiles and medians ([`Quantiles`](super::Quantiles)).
//!
//! Source: M. Grupp, *evo* (Python package, 1.38.1), and those that the other
//! files name; docs/metrics.md explains each figure.
//!
//! Departures: poses are planar; and where evo pairs time stamps, a tick here is
//! scored when it has both a true and an estimated pose made of numbers.
//! Everything else (a recording's ticks between two scans, say) is passed over,
//! and a pair of the relative error is two scored ticks with none between.

use rusty_contract::score::{
    AbsoluteErrors, Alignment, PriorKnowledge, ReferenceNoise, Score, Within,
};
use rusty_contract::{Estimate, Innovation};
use rusty_geometry::SE2;

use super::alignment::aligned_errors;
use super::compute::Times;
use super::consistency::Samples;
use super::convergence::Search;
use super::errors::Errors;
use super::nees::nees;
use super::path::PathLength;
use super::scored::Scored;
use super::trajectory::{FromOrigin, METRE, Relative};
use super::wrong::is_wrong;

/// The shortest way of which an error can be a share, m: that of a step of the
/// relative error. Of less, rounding and the first error make any percentage.
const LEAST_DRIVEN_M: f64 = METRE;

/// What counts as consistent, and what as found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Yardstick {
    /// A right filter is called consistent with this probability, 0 to 1.
    pub level: f64,
    /// How near for how long counts as found.
    pub within: Within,
    /// The true poses' own errors, for NEES.
    pub reference: ReferenceNoise,
}

impl Default for Yardstick {
    /// 95 %; a quarter of a metre and 10° for a second; exact true poses.
    fn default() -> Self {
        Self { level: 0.95, within: Within::default(), reference: ReferenceNoise::default() }
    }
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
    /// Compute time of the answer to this tick, as reported and as observed, ns.
    pub times_ns: Option<[u64; 2]>,
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
    /// Scored ticks with a wrong estimate.
    wrong: u64,
    errors: Errors,
    from_origin: FromOrigin,
    relative: Relative,
    reference: ReferenceNoise,
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
            wrong: 0,
            errors: Errors::expecting(ticks),
            from_origin: FromOrigin::expecting(ticks),
            relative: Relative::expecting(ticks),
            reference: yardstick.reference,
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
    pub fn tick_count(&self) -> u64 {
        self.ticks
    }

    /// Those of them that have a true pose.
    #[must_use]
    pub fn ticks_with_truth(&self) -> u64 {
        self.ticks_with_truth
    }

    /// Distance truly driven, m.
    #[must_use]
    pub fn driven_m(&self) -> f64 {
        self.driven.metres()
    }

    /// One score per estimator, in the order of the names, with what each was told. A
    /// figure is `None` where no scored tick has it: all of them without a scored tick,
    /// the relative ones with a single one, the drift where the error is not one of
    /// driving. `kept` returns the scored ticks of an estimator that are left for the
    /// alignment, which needs all of them at once.
    #[must_use]
    pub fn scores(
        &mut self,
        told: &[PriorKnowledge],
        kept: impl Fn(usize) -> Vec<Scored>,
    ) -> Vec<Score> {
        let (ticks, driven_m) = (self.ticks, self.driven.metres());
        let score = |(i, sums): (usize, &mut Sums)| {
            let mut score = sums.score(ticks, driven_m);
            score.told = told.get(i).copied().unwrap_or_default();
            score.alignment = score.told.alignment();
            if let Some(mut aligned) = aligned_errors(&kept(i))
                && let Some(errors) = aligned.pose_errors()
            {
                (score.ate.se2, score.aligned) = (Some(errors), aligned.figures());
            }
            let by_driving = score.alignment == Alignment::None && !sums.search.is_kidnapped();
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
        given.times_ns.into_iter().for_each(|times_ns| self.times.push(times_ns));
        let estimate = given.estimate.filter(|e| e.pose_in_world.is_finite());
        self.given += u64::from(estimate.is_some());
        let (truth, estimate) = match (moment.truth, estimate) {
            (Some(truth), Some(estimate)) => (truth, estimate),
            (Some(_), None) => return self.search.silent(),
            (None, _) => return,
        };
        let pose = estimate.pose_in_world;
        let scored = Scored { tick: moment.tick as usize, truth, estimate: pose };
        let [error_m, _] = self.errors.push(&pose, &truth);
        self.wrong += u64::from(is_wrong(error_m, &truth, &estimate));
        self.search.push(&scored);
        self.from_origin.push(&scored);
        self.relative.push(&scored);
        if let Some(covariance) = &estimate.covariance {
            let covariance = self.reference.added_to(covariance);
            self.nees.push(nees(&truth, &pose, &covariance), 3);
        }
    }

    fn score(&mut self, ticks: u64, driven_m: f64) -> Score {
        let (figures, rpe) = (self.errors.figures(), self.relative.errors());
        let ate = AbsoluteErrors {
            none: self.errors.pose_errors(),
            origin: self.from_origin.errors(),
            se2: None,
        };
        Score {
            name: self.name.clone(),
            scored_ticks: self.errors.tick_count(),
            unscored_ticks: ticks - self.given,
            wrong_ticks: self.wrong,
            final_position_error_m: figures.final_position_error_m,
            final_heading_error_deg: figures.final_heading_error_rad.map(f64::to_degrees),
            final_heading_error_rad: figures.final_heading_error_rad,
            mean_position_error_m: figures.mean_position_error_m,
            p95_position_error_m: figures.p95_position_error_m,
            max_position_error_m: figures.max_position_error_m,
            rmse_heading_error_rad: figures.rmse_heading_error_rad,
            max_heading_error_rad: figures.max_heading_error_rad,
            ate_rmse_m: figures.ate_rmse_m,
            rpe_rmse_m: rpe.per_tick.map(|e| e.translation_m.rmse),
            rpe_rmse_deg: rpe.per_tick.map(|e| e.rotation_rad.rmse.to_degrees()),
            distance_m: driven_m,
            ate,
            rpe,
            nees: self.nees.consistency(),
            nis: self.nis.consistency(),
            convergence: self.search.convergence(),
            compute: self.times.figures(),
            ..Score::default()
        }
    }
}
