//! Records as journals had them before runs with clients had figures of their
//! own: to be read, never written.

use std::sync::Arc;

use rusty_geometry::SE2;
use serde::Deserialize;

use super::record::Record;
use super::row::Row;
use super::track::{Sample, Track};

/// A [`Record`] of then.
#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
pub struct RecordBefore {
    run: u64,
    rows: Vec<RowBefore>,
    tracks: Vec<TrackBefore>,
    lost: Option<String>,
}

/// The fields of [`Row`], in the same order.
#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
struct RowBefore {
    cell: usize,
    seed: u64,
    estimator: String,
    ticks: u64,
    time_s: f64,
    distance_m: f64,
    final_position_error_m: f64,
    final_heading_error_rad: f64,
    mean_position_error_m: f64,
    ate_rmse_m: f64,
    p95_position_error_m: f64,
    max_position_error_m: f64,
    rmse_heading_error_rad: f64,
    max_heading_error_rad: f64,
    blocked_ticks: Option<u64>,
    digest: String,
}

#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
struct TrackBefore {
    cell: usize,
    seed: u64,
    estimator: String,
    samples: Vec<SampleBefore>,
}

#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
struct SampleBefore {
    time_s: f64,
    distance_m: f64,
    truth: SE2,
    estimate: SE2,
}

impl From<RecordBefore> for Record {
    fn from(before: RecordBefore) -> Self {
        Self {
            run: before.run,
            rows: before.rows.into_iter().map(Row::from).collect(),
            tracks: before.tracks.into_iter().map(Track::from).collect(),
            lost: before.lost,
        }
    }
}

impl From<RowBefore> for Row {
    fn from(before: RowBefore) -> Self {
        Self {
            cell: before.cell,
            seed: before.seed,
            parameters: Arc::from([]),
            estimator: before.estimator,
            ticks: before.ticks,
            time_s: before.time_s,
            distance_m: before.distance_m,
            final_position_error_m: before.final_position_error_m,
            final_heading_error_rad: before.final_heading_error_rad,
            mean_position_error_m: before.mean_position_error_m,
            ate_rmse_m: before.ate_rmse_m,
            p95_position_error_m: before.p95_position_error_m,
            max_position_error_m: before.max_position_error_m,
            rmse_heading_error_rad: before.rmse_heading_error_rad,
            max_heading_error_rad: before.max_heading_error_rad,
            blocked_ticks: before.blocked_ticks,
            digest: before.digest,
            clients: None,
        }
    }
}

impl From<TrackBefore> for Track {
    fn from(before: TrackBefore) -> Self {
        let sample = |s: SampleBefore| Sample {
            time_s: s.time_s,
            distance_m: s.distance_m,
            truth: s.truth,
            estimate: s.estimate,
            nees: None,
        };
        let samples = before.samples.into_iter().map(sample).collect();
        Self { cell: before.cell, seed: before.seed, estimator: before.estimator, samples }
    }
}

/// The bytes of a record that lacks what came later, as they were then.
#[cfg(test)]
pub(super) fn bytes(record: &Record) -> Vec<u8> {
    let row = |r: &Row| RowBefore {
        cell: r.cell,
        seed: r.seed,
        estimator: r.estimator.clone(),
        ticks: r.ticks,
        time_s: r.time_s,
        distance_m: r.distance_m,
        final_position_error_m: r.final_position_error_m,
        final_heading_error_rad: r.final_heading_error_rad,
        mean_position_error_m: r.mean_position_error_m,
        ate_rmse_m: r.ate_rmse_m,
        p95_position_error_m: r.p95_position_error_m,
        max_position_error_m: r.max_position_error_m,
        rmse_heading_error_rad: r.rmse_heading_error_rad,
        max_heading_error_rad: r.max_heading_error_rad,
        blocked_ticks: r.blocked_ticks,
        digest: r.digest.clone(),
    };
    let sample = |s: &Sample| SampleBefore {
        time_s: s.time_s,
        distance_m: s.distance_m,
        truth: s.truth,
        estimate: s.estimate,
    };
    let track = |t: &Track| TrackBefore {
        cell: t.cell,
        seed: t.seed,
        estimator: t.estimator.clone(),
        samples: t.samples.iter().map(sample).collect(),
    };
    let before = RecordBefore {
        run: record.run,
        rows: record.rows.iter().map(row).collect(),
        tracks: record.tracks.iter().map(track).collect(),
        lost: record.lost.clone(),
    };
    postcard::to_allocvec(&before).unwrap()
}
