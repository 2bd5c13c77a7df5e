//! The bands as a text for people.

use std::fmt;

use rusty_contract::score::metres;

use super::band::FIGURES;
use super::lines::Whose;
use super::summary::SummaryRow;

/// The bands of a summary as a text for people.
pub struct Bands<'a>(pub &'a [SummaryRow]);

impl fmt::Display for Bands<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lines = self.0.iter().map(|row| (&*row.parameters, &*row.estimator));
        let Whose { names, width, name } = Whose::of(lines);
        write!(
            f,
            "{:width$}  {:name$}  {:21}  {:>5}  {:>17}  {:>8}  {:>8}  {:>8}",
            "setting", "estimator", "over the seeds", "runs", "mean", "p5", "median", "p95"
        )?;
        for (row, setting) in self.0.iter().zip(&names) {
            for band in &row.bands {
                let words = FIGURES.iter().find(|(figure, ..)| *figure == band.figure);
                let words = words.map_or(band.figure, |(_, words, _)| *words);
                let error = band.standard_error;
                // Equal in all runs but for the rounding of their sum.
                let error = if error < 1e-12 * band.mean.abs() { 0.0 } else { error };
                let mean = format!("{} ± {}", metres(band.mean), metres(error));
                let [p5, median, p95] = [band.p5, band.median, band.p95].map(metres);
                write!(
                    f,
                    "\n{setting:width$}  {:name$}  {words:21}  {:>5}  {mean:>17}  {p5:>8}  \
                     {median:>8}  {p95:>8}",
                    row.estimator, band.n
                )?;
            }
        }
        Ok(())
    }
}
