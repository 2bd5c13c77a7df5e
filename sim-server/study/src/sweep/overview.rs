//! Estimators next to each other, a line each: how far off, whether it knew, when
//! it found the robot, how well it held it then, how long it took.
//!
//! Means are over the runs that have the figure; *found* counts runs, and a time
//! is that of the runs in which it happened, which is why the count stands before
//! it. The rmse after the robot was found is the root of the mean over the runs
//! of the square: of all ticks, if runs are equally long.

use std::fmt;

use rusty_contract::TextTable;
use rusty_contract::score::{Verdict, degrees, duration, metres, share};
use serde::Serialize;

use super::anees::Anees;
use super::client_figures::ClientFigures;
use super::lines::setting;
use super::{Row, Swept};
use rusty_metrics::{Moments, percentile};

/// An estimator in a cell, over all its runs with clients.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Overview {
    /// Index of the cell.
    pub cell: usize,
    /// The cell's swept fields and their values.
    pub parameters: Vec<(String, String)>,
    /// Name in the roster.
    pub estimator: String,
    /// Runs.
    pub runs: usize,
    /// Absolute trajectory error, rmse of the position, no alignment: mean, m.
    pub ate_rmse_m: f64,
    /// The least and the greatest of them.
    pub ate_rmse_range_m: [f64; 2],
    /// The same, aligned in SE(2).
    pub ate_se2_rmse_m: f64,
    /// The least and the greatest of them.
    pub ate_se2_rmse_range_m: [f64; 2],
    /// Relative pose error per metre driven, rmse of the translation: mean, m.
    pub rpe_per_metre_rmse_m: f64,
    /// The same, rotation, rad.
    pub rpe_per_metre_rmse_rad: f64,
    /// Mean over the runs of their mean NEES; expected: 3.
    pub nees: f64,
    /// What follows from it; `None` with too few runs or no covariances.
    pub verdict: Option<Verdict>,
    /// Part of the ticks in which it answered, 0 to 1.
    pub answered: f64,
    /// Part of the answers that were far off without a warning, 0 to 1.
    pub wrong: f64,
    /// Runs in which it found the robot.
    pub found: usize,
    /// When, median of those, s.
    pub found_after_s: f64,
    /// The same, 95th percentile.
    pub found_after_p95_s: f64,
    /// Rmse of the position from there on, m.
    pub then_position_rmse_m: f64,
    /// Rmse of the heading from there on, rad.
    pub then_heading_rmse_rad: f64,
    /// How often the robot was carried away, in all runs.
    pub kidnapped: u64,
    /// How often it was found again.
    pub recovered: u64,
    /// After which time, the first of each run, median, s.
    pub recovered_after_s: f64,
    /// Compute time as reported, median over the runs of their medians, s.
    pub compute_p50_s: f64,
    /// The same of their 99th percentiles.
    pub compute_p99_s: f64,
}

/// A line for each estimator in each cell that has runs with clients, in the
/// order of `consistency`, which is that of the rows.
#[must_use]
pub fn overview(swept: &Swept, consistency: &[Anees]) -> Vec<Overview> {
    consistency.iter().map(|of| line(swept, of)).collect()
}

fn line(swept: &Swept, of: &Anees) -> Overview {
    let own = |row: &&Row| row.cell == of.cell && *row.estimator == *of.estimator;
    let rows = || swept.rows.iter().filter(own);
    let clients: Vec<&ClientFigures> = rows().filter_map(|r| r.clients.as_ref()).collect();
    let finite = |get: fn(&ClientFigures) -> f64| -> Vec<f64> {
        clients.iter().map(|c| get(c)).filter(|v| v.is_finite()).collect()
    };
    let mean = |values: &[f64]| Moments::of(values).mean;
    let at = |values: &mut [f64], p| percentile(values, p).unwrap_or(f64::NAN);
    let median = |get| at(&mut finite(get), 0.5);
    let root = |values: Vec<f64>| mean(&values.iter().map(|v| v * v).collect::<Vec<f64>>()).sqrt();
    let ate: Vec<f64> = rows().map(|r| r.ate_rmse_m).filter(|v| v.is_finite()).collect();
    let aligned = finite(|c| c.ate_se2_rmse_m);
    let range = |values: &[f64]| [0.0, 1.0].map(|p| at(&mut values.to_vec(), p));
    let sum = |get: fn(&ClientFigures) -> u64| clients.iter().map(|c| get(c)).sum::<u64>() as f64;
    let ticks: u64 = rows().filter(|row| row.clients.is_some()).map(|row| row.ticks).sum();
    let scored = sum(|c| c.scored_ticks);
    let mut found = finite(|c| c.converged_after_s);
    Overview {
        cell: of.cell,
        parameters: of.parameters.clone(),
        estimator: of.estimator.clone(),
        runs: clients.len(),
        ate_rmse_m: mean(&ate),
        ate_rmse_range_m: range(&ate),
        ate_se2_rmse_m: mean(&aligned),
        ate_se2_rmse_range_m: range(&aligned),
        rpe_per_metre_rmse_m: mean(&finite(|c| c.rpe_per_metre_rmse_m)),
        rpe_per_metre_rmse_rad: mean(&finite(|c| c.rpe_per_metre_rmse_rad)),
        nees: of.time_mean,
        verdict: of.time_verdict,
        answered: scored / ticks as f64,
        wrong: sum(|c| c.wrong_ticks) / scored,
        found: found.len(),
        found_after_s: at(&mut found, 0.5),
        found_after_p95_s: at(&mut found, 0.95),
        then_position_rmse_m: root(finite(|c| c.found.position_rmse_m)),
        then_heading_rmse_rad: root(finite(|c| c.found.heading_rmse_rad)),
        kidnapped: clients.iter().map(|c| c.found.kidnapped).sum(),
        recovered: clients.iter().map(|c| c.found.recovered).sum(),
        recovered_after_s: median(|c| c.recovered_after_s),
        compute_p50_s: median(|c| c.compute_reported_p50_s),
        compute_p99_s: median(|c| c.compute_reported_p99_s),
    }
}

/// The lines as a text for people.
pub struct OverviewText<'a>(pub &'a [Overview]);

/// A column for people: what stands above it, and what in it.
type Column = (&'static str, fn(&Overview) -> String);

const COLUMNS: [Column; 12] = [
    ("ATE rmse", |o| with_range(o.ate_rmse_m, o.ate_rmse_range_m)),
    ("ATE rmse, SE(2)", |o| with_range(o.ate_se2_rmse_m, o.ate_se2_rmse_range_m)),
    ("RPE per metre", |o| {
        let degrees =
            known(o.rpe_per_metre_rmse_rad, |v| format!(", {} °", degrees(v.to_degrees())));
        known(o.rpe_per_metre_rmse_m, |v| format!("{} m{degrees}", metres(v)))
    }),
    ("NEES of 3", |o| {
        let verdict = o.verdict.map_or(String::new(), |v| format!(" {v}"));
        known(o.nees, |v| format!("{v:.2}{verdict}"))
    }),
    ("answered", |o| known(o.answered, share)),
    ("wrong", |o| known(o.wrong, share)),
    ("found", |o| format!("{} of {}", o.found, o.runs)),
    ("after", |o| known(o.found_after_s, |v| format!("{v:.2} s"))),
    ("then rmse", |o| {
        let degrees =
            known(o.then_heading_rmse_rad, |v| format!(", {} °", degrees(v.to_degrees())));
        known(o.then_position_rmse_m, |v| format!("{} m{degrees}", metres(v)))
    }),
    ("recovered", |o| match o.kidnapped {
        0 => String::new(),
        all if o.recovered_after_s.is_finite() => {
            format!("{} of {all}, {:.1} s", o.recovered, o.recovered_after_s)
        }
        all => format!("{} of {all}", o.recovered),
    }),
    ("compute p50", |o| known(o.compute_p50_s, duration)),
    ("p99", |o| known(o.compute_p99_s, duration)),
];

/// The mean over the runs, and the least and the greatest of them where they differ.
fn with_range(mean_m: f64, [least, greatest]: [f64; 2]) -> String {
    known(mean_m, |mean_m| {
        if least == greatest {
            return format!("{} m", metres(mean_m));
        }
        format!("{} ({}–{}) m", metres(mean_m), metres(least), metres(greatest))
    })
}

fn known(value: f64, text: impl Fn(f64) -> String) -> String {
    if value.is_finite() { text(value) } else { "–".to_owned() }
}

impl fmt::Display for OverviewText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let heads = COLUMNS.map(|(head, _)| head).join("  >");
        let mut table = TextTable::new(&format!("setting  estimator  >{heads}"));
        for line in self.0 {
            let cells = COLUMNS.iter().map(|(_, cell)| cell(line));
            let whose = [setting(&line.parameters), line.estimator.clone()];
            table.push(whose.into_iter().chain(cells).collect());
        }
        write!(f, "{table}")
    }
}

#[cfg(test)]
mod tests {
    use super::super::client_figures::Found;
    use super::super::fixtures::row;
    use super::super::{Swept, anees};
    use super::*;

    fn swept(kidnapped: u64) -> Swept {
        let clients = |seed: u64| ClientFigures {
            converged_after_s: [1.0, 2.0, f64::NAN][seed as usize],
            recovered_after_s: [4.0, f64::NAN, f64::NAN][seed as usize],
            compute_reported_p50_s: 1e-4 * (seed + 1) as f64,
            scored_ticks: 200 + 20 * seed,
            wrong_ticks: 3 * seed,
            found: Found {
                position_rmse_m: [0.03, 0.04, f64::NAN][seed as usize],
                heading_rmse_rad: [0.01, 0.01, f64::NAN][seed as usize],
                kidnapped,
                recovered: u64::from(seed == 0) * kidnapped,
            },
            ..ClientFigures::of(None)
        };
        let rows = (0..3).map(|seed| Row {
            clients: Some(clients(seed)),
            ate_rmse_m: 0.1 * (seed + 2) as f64,
            ..row(0, seed, "mcl")
        });
        Swept { cells: Vec::new(), rows: rows.collect(), tracks: Vec::new() }
    }

    #[test]
    fn counts_stand_before_times_and_squares_are_averaged() {
        let swept = swept(2);
        let lines = overview(&swept, &anees(&swept));
        let o = &lines[0];
        assert_eq!((o.runs, o.found, o.kidnapped, o.recovered), (3, 2, 6, 2));
        assert!((o.then_position_rmse_m - (0.5 * (0.0009 + 0.0016f64)).sqrt()).abs() < 1e-15);
        assert_eq!((o.found_after_s, o.recovered_after_s, o.compute_p50_s), (1.5, 4.0, 2e-4));
        assert_eq!((o.answered, o.wrong), (660.0 / 900.0, 9.0 / 660.0));
        let text = OverviewText(&lines).to_string();
        let found = ["2 of 3", "1.50 s", "0.035 m, 0.57 °", "2 of 6, 4.0 s", "200 µs"];
        for word in found.into_iter().chain(["0.300 (0.200–0.400) m", "73.3 %", "1.4 %"]) {
            assert!(text.contains(word), "{word}: {text}");
        }
    }

    #[test]
    fn nobody_is_asked_for_what_did_not_happen() {
        let swept = swept(0);
        let text = OverviewText(&overview(&swept, &anees(&swept))).to_string();
        assert!(!text.contains("recovered") && text.contains('–'), "{text}");
        let [head, line] = text.lines().collect::<Vec<_>>()[..] else { panic!("{text}") };
        assert_eq!(head.chars().count(), line.chars().count(), "{text}");
    }
}
