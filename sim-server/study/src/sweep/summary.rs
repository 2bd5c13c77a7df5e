//! The table of a sweep: how far off, over all seeds, cell by cell.
//!
//! Source: the table of chapter 4 of the online *Probabilistic Robotics*, "The
//! odometry error budget": mean and 95th percentile of the final position
//! error, and the mean final heading error. Departure: each mean has its
//! standard error next to it, without which two means cannot be compared.

use std::fmt;

use rusty_contract::TextTable;
use rusty_contract::score::{degrees, mean_and_error, metres};
use serde::Serialize;

use super::Row;
use super::band::{Band, bands};
use super::lines::{in_order, setting};
use rusty_metrics::{Moments, percentile};

/// One line: an estimator in a cell, over all its runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SummaryRow {
    /// Index of the cell.
    pub cell: usize,
    /// The cell's swept fields and their values.
    pub parameters: Vec<(String, String)>,
    /// Name in the roster.
    pub estimator: String,
    /// Runs that have a figure.
    pub n: usize,
    /// Runs that have none: nothing was scored in them.
    pub without: usize,
    /// Final position error: mean over the runs, m.
    pub mean_m: f64,
    /// Its standard error, m.
    pub standard_error_m: f64,
    /// 95th percentile over the runs, linear between ranks, m.
    pub p95_m: f64,
    /// The greatest, m.
    pub max_m: f64,
    /// Final heading error without its sign: mean over the runs, degrees.
    pub mean_heading_deg: f64,
    /// Its standard error, degrees.
    pub standard_error_heading_deg: f64,
    /// Other figures over the runs.
    pub bands: Vec<Band>,
}

/// The lines of a sweep, in the order in which cell and estimator first come in
/// `rows`. Cells of which no run has a figure have a line without figures (NaN,
/// which JSON writes as null).
#[must_use]
pub fn summary(rows: &[Row]) -> Vec<SummaryRow> {
    let keys = in_order(rows.iter().map(|row| (row.cell, &*row.estimator)));
    keys.into_iter().filter_map(|(cell, estimator)| line(rows, cell, estimator)).collect()
}

fn line(rows: &[Row], cell: usize, estimator: &str) -> Option<SummaryRow> {
    let own: Vec<&Row> =
        rows.iter().filter(|r| r.cell == cell && *r.estimator == *estimator).collect();
    let scored =
        |r: &&&Row| r.final_position_error_m.is_finite() && r.final_heading_error_rad.is_finite();
    let mut error_m: Vec<f64> =
        own.iter().filter(scored).map(|r| r.final_position_error_m).collect();
    let heading_deg: Vec<f64> =
        own.iter().filter(scored).map(|r| r.final_heading_error_rad.abs().to_degrees()).collect();
    let (position, heading) = (Moments::of(&error_m), Moments::of(&heading_deg));
    Some(SummaryRow {
        cell,
        parameters: own.first()?.parameters.to_vec(),
        estimator: estimator.to_owned(),
        n: position.n,
        without: own.len() - position.n,
        mean_m: position.mean,
        standard_error_m: position.standard_error(),
        p95_m: percentile(&mut error_m, 0.95).unwrap_or(f64::NAN),
        max_m: percentile(&mut error_m, 1.0).unwrap_or(f64::NAN),
        mean_heading_deg: heading.mean,
        standard_error_heading_deg: heading.standard_error(),
        bands: bands(&own),
    })
}

/// The lines as a text for people.
pub struct Summary<'a>(pub &'a [SummaryRow]);

impl fmt::Display for Summary<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = TextTable::new(
            "setting  estimator  >runs  >mean final error  >p95  >max  >mean |heading|",
        );
        for row in self.0 {
            let setting = setting(&row.parameters);
            if row.n == 0 {
                table.row(&[&setting, &row.estimator, &row.n, &"nothing was scored"]);
                continue;
            }
            let [p95, max] = [row.p95_m, row.max_m].map(|m| format!("{} m", metres(m)));
            let error = mean_and_error(row.mean_m, row.standard_error_m, row.n, metres);
            let (mean, error_deg) = (row.mean_heading_deg, row.standard_error_heading_deg);
            let heading = mean_and_error(mean, error_deg, row.n, degrees);
            let (error, heading) = (format!("{error} m"), format!("{heading} °"));
            table.row(&[&setting, &row.estimator, &row.n, &error, &p95, &max, &heading]);
        }
        writeln!(f, "{table}")?;
        write!(
            f,
            "final error and heading are those of the last tick, without alignment; ± is one \
             standard error"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::row;
    use super::*;

    #[test]
    fn a_line_per_cell_and_estimator() {
        let mut rows = Vec::new();
        for cell in 0..2 {
            for seed in 0..5 {
                for name in ["a", "b"] {
                    let mut row = row(cell, seed, name);
                    row.final_position_error_m = [1.0, 2.0, 3.0, 4.0, 10.0][seed as usize];
                    row.final_heading_error_rad = if seed % 2 == 0 { -0.1 } else { 0.1 };
                    rows.push(row);
                }
            }
        }
        rows[3].final_position_error_m = f64::NAN;
        let lines = summary(&rows);
        let keys: Vec<(usize, &str)> =
            lines.iter().map(|l| (l.cell, l.estimator.as_str())).collect();
        assert_eq!(keys, [(0, "a"), (0, "b"), (1, "a"), (1, "b")]);
        let first = &lines[0];
        assert_eq!((first.n, first.mean_m, first.max_m), (5, 4.0, 10.0));
        assert!((first.standard_error_m - (12.5_f64 / 5.0).sqrt()).abs() < 1e-15);
        assert!((first.p95_m - 8.8).abs() < 1e-12, "{}", first.p95_m);
        assert!((first.mean_heading_deg - 0.1_f64.to_degrees()).abs() < 1e-12);
        assert_eq!((lines[1].n, lines[1].without), (4, 1));
    }

    #[test]
    fn the_text_has_a_line_each_and_says_where_nothing_is() {
        let mut rows: Vec<Row> = (0..3).map(|seed| row(0, seed, "dead-reckoning")).collect();
        rows.push(Row { final_position_error_m: f64::NAN, ..row(1, 0, "dead-reckoning") });
        let text = Summary(&summary(&rows)).to_string();
        assert_eq!(text.lines().count(), 4, "{text}");
        assert!(text.contains("nothing was scored"), "{text}");
        let widths: Vec<usize> =
            text.lines().take(2).map(|l| l.trim_end().chars().count()).collect();
        assert_eq!(widths[0], widths[1], "{text}");
    }
}
