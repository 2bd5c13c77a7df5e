//! How a figure lies over the seeds: mean, and the middle nine tenths.

use serde::Serialize;

use super::Row;
use super::client_figures::ClientFigures;
use rusty_metrics::{Moments, percentile};

/// A figure of one estimator in one cell, over the seeds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Band {
    /// The column of the table.
    pub figure: &'static str,
    /// Runs that have it.
    pub n: usize,
    /// Mean.
    pub mean: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// 5th percentile, linear between ranks.
    pub p5: f64,
    /// Median.
    pub median: f64,
    /// 95th percentile.
    pub p95: f64,
}

/// A figure of a row; NaN if it has none.
type Figure = fn(&Row) -> f64;

/// A figure of a row with clients.
macro_rules! of_clients {
    ($field:ident) => {
        |row| row.clients.as_ref().map_or(f64::NAN, |c: &ClientFigures| c.$field)
    };
}

/// The figures that have a band: column and name for people.
pub(super) const FIGURES: [(&str, &str, Figure); 6] = [
    ("ate_rmse_m", "ATE rmse, m", |row| row.ate_rmse_m),
    ("ate_se2_rmse_m", "ATE rmse, SE(2), m", of_clients!(ate_se2_rmse_m)),
    ("rpe_per_metre_rmse_m", "RPE rmse per metre, m", of_clients!(rpe_per_metre_rmse_m)),
    ("nees_mean", "mean NEES", of_clients!(nees_mean)),
    ("z_short", "beams in front of the map (z_short)", |row| row.z_short),
    ("converged_after_s", "converged after, s", of_clients!(converged_after_s)),
];

/// The bands of one estimator's rows in one cell: of every figure that a run
/// has.
#[must_use]
pub fn bands(rows: &[&Row]) -> Vec<Band> {
    let band = |(figure, _, of): &(&'static str, &str, Figure)| {
        let mut values: Vec<f64> = rows.iter().map(|r| of(r)).filter(|v| v.is_finite()).collect();
        let moments = Moments::of(&values);
        let mut at = |fraction| percentile(&mut values, fraction).unwrap_or(f64::NAN);
        (moments.n > 0).then(|| Band {
            figure,
            n: moments.n,
            mean: moments.mean,
            standard_error: moments.standard_error(),
            p5: at(0.05),
            median: at(0.5),
            p95: at(0.95),
        })
    };
    FIGURES.iter().filter_map(band).collect()
}

#[cfg(test)]
mod tests {
    use super::super::bands_text::Bands;
    use super::super::fixtures::row;
    use super::super::summary;
    use super::*;

    #[test]
    fn a_figure_that_some_runs_have_has_a_band() {
        let with = |seed: u64| Row {
            ate_rmse_m: [0.1, 0.2, 0.3, 0.4, f64::NAN][seed as usize],
            clients: (seed < 2)
                .then(|| ClientFigures { nees_mean: 3.0 + seed as f64, ..ClientFigures::of(None) }),
            z_short: f64::NAN,
            ..row(0, seed, "a")
        };
        let rows: Vec<Row> = (0..5).map(with).collect();
        let lines = summary(&rows);
        let bands = &lines[0].bands;
        let found: Vec<(&str, usize)> = bands.iter().map(|b| (b.figure, b.n)).collect();
        assert_eq!(found, [("ate_rmse_m", 4), ("nees_mean", 2)]);
        assert!((bands[0].mean - 0.25).abs() < 1e-15 && (bands[0].median - 0.25).abs() < 1e-15);
        assert!((bands[0].p5 - 0.115).abs() < 1e-12 && (bands[0].p95 - 0.385).abs() < 1e-12);
        assert_eq!((bands[1].mean, bands[1].standard_error), (3.5, 0.5));
        let text = Bands(&lines).to_string();
        assert!(text.contains("mean NEES") && text.lines().count() == 3, "{text}");
    }
}
