//! Scores and verdicts: what the runs of a benchmark show.

use std::collections::BTreeMap;

use rusty_metrics::Moments;
use rusty_metrics::student::half_width;
use serde::{Deserialize, Serialize};

use super::entry::Entry;
use super::run::BenchmarkRun;
use super::selection::Selection;
use super::suite::{Suite, SuiteScenario};
use super::track::Track;
use crate::versus::Metric;
use crate::versus::contest::{Better, Outcome};

/// Probability of the intervals.
pub const LEVEL: f64 = 0.95;

/// Where a figure is about the ticks that were answered, a run has it only if it answered at
/// least this part of what the baselines did. One answer at a known start has no error.
const LEAST_ANSWERED: f64 = 0.9;

/// A metric of an entry in a scenario, over the seeds. Less is better.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BenchmarkScore {
    /// Name of the scenario.
    pub scenario: String,
    /// The track.
    pub track: Track,
    /// Name of the entry.
    pub entry: String,
    /// The metric.
    pub metric: Metric,
    /// Its unit.
    pub unit: String,
    /// Runs with a figure.
    pub runs: usize,
    /// Runs that failed.
    pub failed: usize,
    /// Runs that did not fail and have no figure: what is measured did not happen, or too
    /// few ticks were answered.
    pub without: usize,
    /// Mean over the runs with a figure.
    pub mean: Option<f64>,
    /// Interval of the mean (Student's t, 95 %); null with one run.
    pub interval: Option<[f64; 2]>,
}

/// An entry compared with a baseline, seed by seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BenchmarkVerdict {
    /// Name of the scenario.
    pub scenario: String,
    /// The track.
    pub track: Track,
    /// The metric.
    pub metric: Metric,
    /// Whether it is the metric that decides in this scenario.
    pub decides: bool,
    /// Name of the entry.
    pub entry: String,
    /// Name of the baseline.
    pub baseline: String,
    /// Whether the baseline is the reference of the track.
    pub is_reference: bool,
    /// Seeds with a figure of both.
    pub pairs: usize,
    /// Mean of the baseline and of the entry over the pairs.
    pub means: [Option<f64>; 2],
    /// The entry's mean less the baseline's.
    pub difference: Option<f64>,
    /// Interval of the difference (Student's t over the pairs, 95 %).
    pub interval: [Option<f64>; 2],
    /// Seeds in which the baseline has less, and in which the entry has. A run without a
    /// figure has more than any with one.
    pub wins: [u64; 2],
    /// Probability of wins as uneven if neither is better (sign test, exact).
    pub sign_p: f64,
    /// Who is better; null if neither is shown to be.
    pub better: Option<Side>,
    /// The verdict as a sentence.
    pub text: String,
}

/// Who is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// The baseline.
    Baseline,
    /// The entry.
    Entry,
}

/// Returns scores and verdicts of the runs, in the order of the suite.
#[must_use]
pub fn standings(
    suite: &Suite,
    selection: &Selection,
    entries: &[Entry],
    runs: &[BenchmarkRun],
) -> (Vec<BenchmarkScore>, Vec<BenchmarkVerdict>) {
    let (mut scores, mut verdicts) = (Vec::new(), Vec::new());
    for (scenario, track) in selection.blocks(suite) {
        let place = Place::new(suite, (scenario, track), runs);
        let all: Vec<&Entry> =
            entries.iter().filter(|e| e.takes_part(suite, scenario, track)).collect();
        for (rank, metric) in scenario.metrics(track).iter().enumerate() {
            scores.extend(all.iter().map(|entry| place.score(entry, *metric)));
            for entry in &all {
                for (at, baseline) in suite.baselines_of(scenario, track).enumerate() {
                    if baseline.name != entry.name {
                        let names = [baseline.name.as_str(), entry.name.as_str()];
                        verdicts.push(place.verdict(names, *metric, [rank == 0, at == 0]));
                    }
                }
            }
        }
    }
    (scores, verdicts)
}

/// A track in a scenario.
pub(super) struct Place<'s> {
    scenario: &'s SuiteScenario,
    track: Track,
    runs: &'s [BenchmarkRun],
    /// Answered ticks of the baseline that answered most, by seed.
    most_answered: BTreeMap<u64, u64>,
}

impl<'s> Place<'s> {
    pub(super) fn new(
        suite: &'s Suite,
        (scenario, track): (&'s SuiteScenario, Track),
        runs: &'s [BenchmarkRun],
    ) -> Self {
        let place = Self { scenario, track, runs, most_answered: BTreeMap::new() };
        let mut most_answered = BTreeMap::<u64, u64>::new();
        let baselines = suite.baselines_of(scenario, track);
        for run in baselines.flat_map(|baseline| place.runs_of(&baseline.name)) {
            let most = most_answered.entry(run.seed).or_default();
            *most = run.answered_ticks.max(*most);
        }
        Self { most_answered, ..place }
    }

    pub(super) fn runs_of(&self, entry: &str) -> impl Iterator<Item = &BenchmarkRun> {
        let (scenario, map) = (&self.scenario.name, self.track.map());
        let is_its = move |run: &&BenchmarkRun| {
            run.scenario == *scenario && run.map == map && run.entry == entry
        };
        self.runs.iter().filter(is_its)
    }

    /// The figure of a run. A failed run has none, and neither has one that answered less
    /// than the baselines did.
    pub(super) fn figure(&self, run: &BenchmarkRun, metric: Metric) -> Option<f64> {
        let least = LEAST_ANSWERED * self.most_answered(run) as f64;
        let has_enough = run.answered_ticks as f64 >= least;
        let figure = run.figures.get(&metric).copied().flatten();
        figure.filter(|_| run.failure.is_none() && (!metric.is_of_answers() || has_enough))
    }

    /// Answered ticks of the baseline that answered most of the same run.
    pub(super) fn most_answered(&self, run: &BenchmarkRun) -> u64 {
        self.most_answered.get(&run.seed).copied().unwrap_or(0)
    }

    fn score(&self, entry: &Entry, metric: Metric) -> BenchmarkScore {
        // In the order of the seeds: their sum depends on it in its last bits.
        let mut runs: Vec<&BenchmarkRun> = self.runs_of(&entry.name).collect();
        runs.sort_by_key(|run| run.seed);
        let figures: Vec<f64> =
            runs.into_iter().filter_map(|run| self.figure(run, metric)).collect();
        let failed = self.runs_of(&entry.name).filter(|run| run.failure.is_some()).count();
        let moments = Moments::of(&figures);
        let half = half_width(&moments, LEVEL);
        let interval = [moments.mean - half, moments.mean + half];
        BenchmarkScore {
            scenario: self.scenario.name.clone(),
            track: self.track,
            entry: entry.name.clone(),
            metric,
            unit: metric.unit().to_owned(),
            runs: figures.len(),
            failed,
            without: self.runs_of(&entry.name).count() - figures.len() - failed,
            mean: known(moments.mean),
            interval: half.is_finite().then_some(interval),
        }
    }

    fn verdict(
        &self,
        names: [&str; 2],
        metric: Metric,
        [decides, is_reference]: [bool; 2],
    ) -> BenchmarkVerdict {
        let mut figures: BTreeMap<u64, [Option<f64>; 2]> = BTreeMap::new();
        for (side, name) in names.iter().enumerate() {
            for run in self.runs_of(name) {
                figures.entry(run.seed).or_default()[side] = self.figure(run, metric);
            }
        }
        let samples = if self.scenario.is_recorded() { "recordings" } else { "seeds" };
        let outcome = Outcome::of(metric, figures, true, (names, samples), LEVEL);
        let [baseline, entry] = names.map(str::to_owned);
        BenchmarkVerdict {
            scenario: self.scenario.name.clone(),
            track: self.track,
            metric,
            decides,
            entry,
            baseline,
            is_reference,
            pairs: outcome.paired.pairs,
            means: outcome.paired.means.map(known),
            difference: known(outcome.paired.difference),
            interval: outcome.interval.map(known),
            wins: outcome.wins,
            sign_p: outcome.sign_p,
            better: outcome.better.map(|better| match better {
                Better::A => Side::Baseline,
                Better::B => Side::Entry,
            }),
            text: outcome.verdict,
        }
    }
}

fn known(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
