//! Whether an estimator's errors are as large as it reports, over the seeds.
//! docs/metrics.md has the source.
//!
//! Ticks of one run depend on each other. So the interval holds at one tick, and the
//! verdict is that of the last; of the ticks along the way the share inside is given.
//! The mean over time is one number for each run, with a t interval over the runs, which
//! is at most as wide as for errors that stay the same for a whole run.
//! Innovations of a consistent filter are independent: the NIS of all are taken together.

use std::collections::BTreeMap;
use std::fmt;

use rusty_contract::TextTable;
use rusty_contract::score::Verdict;
use serde::Serialize;

use super::lines::setting;
use super::{Row, Swept, Track};
use rusty_metrics::Moments;
use rusty_metrics::chi_square::mean_interval;
use rusty_metrics::student::half_width;

/// Probability of the intervals.
pub const LEVEL: f64 = 0.95;
/// Degrees of freedom of a pose.
const POSE: f64 = 3.0;

/// What the runs of an estimator in a cell say of its covariances.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Anees {
    /// Index of the cell.
    pub cell: usize,
    /// The cell's swept fields and their values.
    pub parameters: Vec<(String, String)>,
    /// Name in the roster.
    pub estimator: String,
    /// Runs with a NEES.
    pub runs: usize,
    /// Runs without one: no covariance was reported, or none that is one.
    pub without: usize,
    /// Probability of the intervals.
    pub level: f64,
    /// At the last tick of each run that has a covariance of full rank; `None`
    /// (unscored) without a run that has one.
    pub last: Option<Average>,
    /// At ticks along the way, of the runs that were followed.
    pub along: Vec<Average>,
    /// Share of those that are in their interval; NaN without one.
    pub share_inside: f64,
    /// Mean over the runs of their means over the ticks.
    pub time_mean: f64,
    /// Half the width of its interval (Student's t); NaN with fewer than two runs.
    pub time_mean_half_width: f64,
    /// What follows from mean, half width and number of runs; `None` with fewer than two.
    pub time_verdict: Option<Verdict>,
    /// Innovations of all runs together; `None` where none was reported.
    pub nis: Option<Innovations>,
}

/// The mean of one tick's NEES over runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Average {
    /// Time at the end of the tick, s; NaN for the last tick of runs that did
    /// not end together.
    pub time_s: f64,
    /// How many runs.
    pub n: usize,
    /// Their mean; expected: 3.
    pub anees: f64,
    /// It is in here with probability `level` if the covariances are right.
    pub interval: [f64; 2],
    /// What follows.
    pub verdict: Verdict,
}

/// The NIS of many ticks of many runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Innovations {
    /// How many.
    pub samples: u64,
    /// Their sum over their degrees of freedom; expected: 1.
    pub per_degree: f64,
    /// It is in here with probability `level` if the innovation covariances
    /// are right.
    pub interval: [f64; 2],
    /// What follows.
    pub verdict: Verdict,
}

impl Average {
    /// The mean of `values`, at least one.
    fn of(time_s: f64, values: &[f64]) -> Self {
        let (n, anees) = (values.len(), Moments::of(values).mean);
        let interval = mean_interval(n as f64, POSE, LEVEL);
        Self { time_s, n, anees, interval, verdict: Verdict::of(anees, interval) }
    }

    /// Whether the mean is in its interval.
    #[must_use]
    pub fn is_inside(&self) -> bool {
        self.verdict == Verdict::Consistent
    }
}

/// A line for each estimator in each cell, in the order in which they first
/// come in the rows; none of rows that were made inside, where no participant reports a
/// covariance.
#[must_use]
pub fn anees(swept: &Swept) -> Vec<Anees> {
    let mut rows: Vec<((usize, &str), Vec<&Row>)> = Vec::new();
    for row in swept.rows.iter().filter(|row| row.clients.is_some()) {
        let key = (row.cell, &*row.estimator);
        match rows.iter_mut().rev().find(|(k, _)| *k == key) {
            Some((_, own)) => own.push(row),
            None => rows.push((key, vec![row])),
        }
    }
    let own = |(cell, name): (usize, &str)| {
        let of = swept.tracks.iter().filter(move |t| t.cell == cell && t.estimator == name);
        of.collect::<Vec<&Track>>()
    };
    rows.iter().filter_map(|(key, rows)| line(rows, &own(*key))).collect()
}

fn line(rows: &[&Row], tracks: &[&Track]) -> Option<Anees> {
    let first = rows.first()?;
    let figures = || rows.iter().filter_map(|row| Some((row.time_s, row.clients.as_ref()?)));
    let ended: Vec<(f64, f64)> =
        figures().map(|(t, c)| (t, c.nees_last)).filter(|(_, v)| v.is_finite()).collect();
    let lasts: Vec<f64> = ended.iter().map(|(_, value)| *value).collect();
    let together = ended.windows(2).all(|w| w[0].0 == w[1].0);
    let time_s = ended.first().filter(|_| together).map_or(f64::NAN, |(t, _)| *t);
    let means: Vec<f64> = figures().map(|(_, c)| c.nees_mean).filter(|v| v.is_finite()).collect();
    let means = Moments::of(&means);
    let half = half_width(&means, LEVEL);
    let along = along(tracks);
    let inside = along.iter().filter(|a| a.is_inside()).count();
    Some(Anees {
        cell: first.cell,
        parameters: first.parameters.to_vec(),
        estimator: first.estimator.clone(),
        runs: lasts.len(),
        without: rows.len() - lasts.len(),
        level: LEVEL,
        last: (!lasts.is_empty()).then(|| Average::of(time_s, &lasts)),
        share_inside: inside as f64 / along.len() as f64,
        along,
        time_mean: means.mean,
        time_mean_half_width: half,
        time_verdict: (means.n > 1).then(|| over_time(&means, half)),
        nis: innovations(rows),
    })
}

/// The verdict on the mean over time. The t interval grows with the spread of the runs: one
/// that is lost would widen it around any mean. If the covariances are right, the mean of a
/// run scatters no more than one NEES does, so the interval of that limits it.
fn over_time(means: &Moments, half: f64) -> Verdict {
    let [low, high] = mean_interval(means.n as f64, POSE, LEVEL);
    Verdict::of(means.mean, [low.max(POSE - half), high.min(POSE + half)])
}

/// The means at the ticks that the tracks have, in order of time.
fn along(tracks: &[&Track]) -> Vec<Average> {
    let mut at: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for sample in tracks.iter().flat_map(|track| &track.samples) {
        if let Some(nees) = sample.nees {
            // Times of a simulation are above zero: their bits have their order.
            at.entry(sample.time_s.to_bits()).or_default().push(nees);
        }
    }
    at.into_iter().map(|(time, values)| Average::of(f64::from_bits(time), &values)).collect()
}

fn innovations(rows: &[&Row]) -> Option<Innovations> {
    let said = || rows.iter().filter_map(|row| row.clients.as_ref()).filter(|c| c.nis_samples > 0);
    let degrees: f64 = said().map(|c| c.nis_degrees).sum();
    let per_degree = said().map(|c| c.nis_sum).sum::<f64>() / degrees;
    let interval = mean_interval(1.0, degrees, LEVEL).map(|end| end / degrees);
    let samples = said().map(|c| c.nis_samples).sum();
    let verdict = Verdict::of(per_degree, interval);
    (samples > 0).then_some(Innovations { samples, per_degree, interval, verdict })
}

/// The lines as a text for people.
pub struct AneesText<'a>(pub &'a [Anees]);

impl fmt::Display for AneesText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = TextTable::new(
            "setting  estimator  >runs  >ANEES  >accepted  >verdict  >inside  >mean over time  verdict over time",
        );
        for line in self.0 {
            let setting = setting(&line.parameters);
            let Some(last) = &line.last else {
                let remark = "unscored: no covariance is reported";
                table.row(&[&setting, &line.estimator, &line.runs, &remark]);
                continue;
            };
            let accepted = format!("[{:.2}, {:.2}]", last.interval[0], last.interval[1]);
            let inside = match line.share_inside {
                share if share.is_nan() => "–".to_owned(),
                share => format!("{:.0} %", 100.0 * share),
            };
            let over_time = match line.time_mean_half_width {
                half if half.is_nan() => number(line.time_mean),
                half => format!("{} ± {}", number(line.time_mean), number(half)),
            };
            let time_verdict = line.time_verdict.map_or("", Verdict::word);
            table.row(&[
                &setting,
                &line.estimator,
                &line.runs,
                &number(last.anees),
                &accepted,
                &last.verdict.word(),
                &inside,
                &over_time,
                &time_verdict,
            ]);
            if let Some(nis) = &line.nis {
                let ([low, high], per_degree) = (nis.interval, number(nis.per_degree));
                let remark = format!(
                    "NIS per degree {per_degree}, accepted [{low:.3}, {high:.3}]: {} ({} innovations)",
                    nis.verdict, nis.samples
                );
                table.row(&[&"", &remark]);
            }
        }
        write!(f, "{table}")?;
        write!(
            f,
            "\nANEES: mean over the seeds of the normalised squared error at the last tick that \
             has one, 3 if the covariances are right; accepted and ± at {:.0} %; inside: of the ticks along the way",
            100.0 * LEVEL
        )
    }
}

fn number(value: f64) -> String {
    if value.abs() < 1e4 { format!("{value:.2}") } else { format!("{value:.1e}") }
}

#[cfg(test)]
#[path = "anees_tests.rs"]
mod tests;
