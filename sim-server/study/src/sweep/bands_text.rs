//! The bands as a text for people.

use std::fmt;

use rusty_contract::TextTable;
use rusty_contract::score::{mean_and_error, metres};

use super::band::FIGURES;
use super::lines::setting;
use super::summary::SummaryRow;

/// The bands of a summary as a text for people.
pub struct Bands<'a>(pub &'a [SummaryRow]);

impl fmt::Display for Bands<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table =
            TextTable::new("setting  estimator  over the seeds  >runs  >mean  >p5  >median  >p95");
        for row in self.0 {
            let setting = setting(&row.parameters);
            for band in &row.bands {
                let words = FIGURES.iter().find(|(figure, ..)| *figure == band.figure);
                let words = words.map_or(band.figure, |(_, words, _)| *words);
                let error = band.standard_error;
                // Equal in all runs but for the rounding of their sum.
                let error = if error < 1e-12 * band.mean.abs() { 0.0 } else { error };
                let mean = mean_and_error(band.mean, error, band.n, metres);
                let [p5, median, p95] = [band.p5, band.median, band.p95].map(metres);
                table.row(&[&setting, &row.estimator, &words, &band.n, &mean, &p5, &median, &p95]);
            }
        }
        write!(f, "{table}")
    }
}
