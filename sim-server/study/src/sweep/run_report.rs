//! What a run with clients comes to: its rows, tracks and losses. The scorer's `score.json`
//! gives the figures, the logger's log, where there is one, the way.

use std::path::Path;

use rusty_contract::json::through_tree;
use rusty_contract::log::{LogReader, Read};
use rusty_contract::score::{Alignment, GoalScore, Score};
use rusty_contract::{Effects, RunConfig};
use rusty_metrics::{PathLength, nees};
use serde::Deserialize;

use super::client_figures::ClientFigures;
use super::error::SweepError;
use super::inside::Place;
use super::plan::{Plan, Sampling};
use super::record::Record;
use super::row::Row;
use super::track::{Sample, Track};

/// What of a run is looked at: from the report of a launch, or made here.
#[derive(Deserialize)]
pub(crate) struct RunReport {
    pub(super) ticks: u64,
    pub(crate) ended: String,
    pub(super) digest: String,
    #[serde(deserialize_with = "through_tree")]
    pub(super) scores: Vec<Score>,
    pub(super) blocked_ticks: Option<u64>,
    #[serde(default)]
    pub(super) goals: Option<GoalScore>,
    pub(super) losses: Vec<LostClient>,
    pub(super) remarks: Vec<String>,
}

/// A participant that was lost.
#[derive(Deserialize)]
pub(super) struct LostClient {
    pub(super) name: String,
    pub(super) detail: String,
}

impl RunReport {
    /// The record of this run, whose log is in the folder `out`.
    pub(super) fn record(&self, plan: &Plan, run: u64, out: &Path) -> Record {
        let (cell, seed) = plan.place(run);
        let config = &plan.cells[cell].config;
        let place = |name: &str| Place { cell, seed, estimator: name.to_owned() };
        let mut rows = Vec::new();
        for name in plan.rosters[cell].iter().filter(|p| p.answers()).map(|p| p.name.as_str()) {
            rows.push(self.row(place(name), config));
        }
        let sampling = plan.sampling(run);
        let tracks = match sampling.count() {
            0 => Vec::new(),
            _ => tracks(&out.join("run.log"), sampling, &place).unwrap_or_default(),
        };
        Record { run, rows, tracks, lost: self.lost() }
    }

    /// The row of an estimator.
    pub(crate) fn row(&self, place: Place, config: &RunConfig) -> Row {
        let score = self.scores.iter().find(|s| s.name == place.estimator);
        let mut row = place.row(&score.map(|s| s.figures(Alignment::None)).unwrap_or_default());
        row.ticks = self.ticks;
        row.time_s = self.ticks.checked_sub(1).map_or(0.0, |tick| config.time_s(tick));
        row.distance_m = score.map_or(f64::NAN, |s| s.distance_m);
        row.blocked_ticks = self.blocked_ticks;
        row.digest.clone_from(&self.digest);
        row.clients = Some(ClientFigures::of(score).with_goals(self.goals));
        row
    }

    /// What was lost or is odd, in one line: a table has one for each run.
    pub(crate) fn lost(&self) -> Option<String> {
        let losses = self.losses.iter().map(|l| format!("{}: {}", l.name, l.detail));
        let all = losses.chain(self.remarks.iter().cloned());
        let all: Vec<String> = all.map(|text| text.replace("\n    ", " | ")).collect();
        (!all.is_empty()).then(|| all.join("; "))
    }
}

/// A run that could not be made.
pub(super) fn failed(plan: &Plan, run: u64, why: String) -> SweepError {
    let (seed, cell) = in_words(plan, run);
    SweepError::Launch { seed, cell, why }
}

/// The seed of a run and its swept fields, in words.
pub(super) fn in_words(plan: &Plan, run: u64) -> (u64, String) {
    let (cell, seed) = plan.place(run);
    let parameters = plan.cells[cell].parameters.iter();
    (seed, parameters.map(|(k, v)| format!(", {k}={v}")).collect())
}

/// The way of every estimator of a log; `None` without a log that can be read.
fn tracks(log: &Path, mut sampling: Sampling, place: &dyn Fn(&str) -> Place) -> Option<Vec<Track>> {
    let mut reader = LogReader::open(log).ok()?;
    let header = reader.header().clone();
    let mut effects = Effects::of(&header);
    let mut samples: Vec<Vec<Sample>> = header.answering().map(|_| Vec::new()).collect();
    let carried_at = header.kidnappings().map(|k| k.tick).collect();
    let (mut path, mut next) =
        (PathLength::new(header.true_start(), carried_at), sampling.next_tick());
    while let Ok(Read::Tick(entry)) = reader.read() {
        let record = entry.record;
        let has_scan = record.ranges_m.is_some();
        effects.close(record.tick, has_scan, record.replies.iter().copied());
        let truth = record.pose_in_world().filter(|p| p.is_finite());
        truth.iter().for_each(|pose| path.push(record.tick, pose));
        if record.tick != next {
            continue;
        }
        next = sampling.next_tick();
        for (samples, reply) in samples.iter_mut().zip(effects.replies()) {
            let estimate = reply.estimate().filter(|e| e.pose_in_world.is_finite());
            if let (Some(truth), Some(estimate)) = (truth, estimate) {
                let time_s = header.config.time_s(record.tick);
                let (distance_m, covariance) = (path.metres(), estimate.covariance);
                let estimate = estimate.pose_in_world;
                let nees = covariance.and_then(|c| nees(&truth, &estimate, &c));
                samples.push(Sample { time_s, distance_m, truth, estimate, nees });
            }
        }
    }
    let names = header.answering().map(|p| p.name.as_str());
    Some(names.zip(samples).map(|(name, samples)| place(name).track(samples)).collect())
}
