//! `BenchmarkRun`: the figures of an entry in one run.

use std::collections::BTreeMap;

use rusty_contract::scenario::Access;
use serde::{Deserialize, Serialize};

use super::suite::SuiteScenario;
use crate::sweep::Row;
use crate::versus::Metric;

/// One run of an entry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BenchmarkRun {
    /// Name of the scenario.
    pub scenario: String,
    /// Whether the entry had the map.
    pub map: Access,
    /// Name of the entry.
    pub entry: String,
    /// The seed of all noise.
    pub seed: u64,
    /// Run digest, 32 hexadecimal digits: of all frames, truths and answers.
    pub digest: String,
    /// Complete ticks.
    pub ticks: u64,
    /// Ticks with an answer and a true pose.
    pub answered_ticks: u64,
    /// Distance truly driven, m; null where nothing was scored.
    pub distance_m: Option<f64>,
    /// The reason why the run failed; null where it did not. A failed run has no figures.
    pub failure: Option<String>,
    /// Figures by metric; null where the run has none.
    pub figures: BTreeMap<Metric, Option<f64>>,
    /// Compute time as the entry reports it, median, s.
    pub compute_p50_s: Option<f64>,
    /// The same, 99th percentile, s.
    pub compute_p99_s: Option<f64>,
}

impl BenchmarkRun {
    /// Returns the run of a row; `planned` is its number of ticks.
    #[must_use]
    pub fn of(
        row: &Row,
        lost: Option<&str>,
        planned: u64,
        (scenario, map): (&SuiteScenario, Access),
    ) -> Self {
        let known = |value: f64| value.is_finite().then_some(value);
        // A driver may end the run once it is there.
        let is_there = Metric::Goals.of_row(row).is_finite();
        let cut = (row.ticks < planned && !is_there)
            .then(|| format!("it ended after {} of {planned} ticks", row.ticks));
        let failure = lost.map(str::to_owned).or(cut);
        let figure = |metric: Metric| known(metric.of_row(row)).filter(|_| failure.is_none());
        let figures = scenario.metrics_with(map).into_iter().map(|m| (m, figure(m))).collect();
        let compute = |of: fn(&crate::sweep::client_figures::ClientFigures) -> f64| {
            row.clients.as_ref().map(of).and_then(known)
        };
        Self {
            scenario: scenario.name.clone(),
            map,
            entry: row.estimator.clone(),
            seed: row.seed,
            digest: row.digest.clone(),
            ticks: row.ticks,
            answered_ticks: row.clients.as_ref().map_or(0, |c| c.scored_ticks),
            distance_m: known(row.distance_m),
            figures,
            compute_p50_s: compute(|c| c.compute_reported_p50_s),
            compute_p99_s: compute(|c| c.compute_reported_p99_s),
            failure,
        }
    }
}
