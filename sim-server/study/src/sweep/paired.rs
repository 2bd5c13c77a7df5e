//! Two settings on the same seeds: what common random numbers gain.
//!
//! Noise is placed by (seed, source, tick, beam), so the runs of one seed in two
//! cells meet the same noise, and what chance adds to one it adds to the other.
//! The difference is then taken seed by seed; [`Paired`] says how, and what is
//! gained by it.

use std::collections::BTreeMap;
use std::fmt;

use rusty_contract::score::{degrees, metres};
use serde::Serialize;

use super::lines::{in_order, setting};
use super::{Row, Swept};
use rusty_metrics::Paired;

/// Probability of the intervals.
const LEVEL: f64 = 0.95;
/// Seeds listed in a text before "and N more".
const SHOWN: usize = 8;

/// A figure of one estimator in two cells, A and B.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CellPair {
    /// Name in the roster.
    pub estimator: String,
    /// Which figure, with its unit.
    pub figure: Figure,
    /// Index of cell A, and of cell B.
    pub cells: [usize; 2],
    /// What is set in A, and in B.
    pub settings: [String; 2],
    /// The comparison; intervals are at 95 %.
    #[serde(flatten)]
    pub paired: Paired,
}

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Figure {
    /// Final position error, m.
    FinalPositionErrorM,
    /// Final heading error without its sign, degrees.
    FinalHeadingErrorDeg,
}

impl Figure {
    fn of(self, row: &Row) -> f64 {
        match self {
            Self::FinalPositionErrorM => row.final_position_error_m,
            Self::FinalHeadingErrorDeg => row.final_heading_error_rad.abs().to_degrees(),
        }
    }

    fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::FinalPositionErrorM => ("final error", "m"),
            Self::FinalHeadingErrorDeg => ("|heading|", "°"),
        }
    }

    fn number(self, value: f64) -> String {
        match self {
            Self::FinalPositionErrorM => metres(value),
            Self::FinalHeadingErrorDeg => degrees(value),
        }
    }
}

/// What `--ab` says: its two values are those of the field that changes fastest,
/// so cells 0 and 1 differ in it alone, and 2 and 3, and so on.
#[must_use]
pub fn ab(swept: &Swept) -> Vec<CellPair> {
    let first = (0..swept.cells.len()).step_by(2).filter(|a| a + 1 < swept.cells.len());
    first.flat_map(|a| paired(&swept.rows, [a, a + 1])).collect()
}

/// Both figures of every estimator, B less A, in the order in which estimators
/// first come in `rows`.
#[must_use]
pub fn paired(rows: &[Row], cells: [usize; 2]) -> Vec<CellPair> {
    let own = rows.iter().filter(|r| cells.contains(&r.cell));
    let names = in_order(own.map(|r| &*r.estimator));
    let figures = [Figure::FinalPositionErrorM, Figure::FinalHeadingErrorDeg];
    names
        .into_iter()
        .flat_map(|name| figures.map(|figure| compare(rows, cells, name, figure)))
        .collect()
}

fn compare(rows: &[Row], cells: [usize; 2], estimator: &str, figure: Figure) -> CellPair {
    let own = |cell: usize| rows.iter().filter(move |r| r.cell == cell && r.estimator == estimator);
    let mut figures: BTreeMap<u64, [Option<f64>; 2]> = BTreeMap::new();
    for (side, cell) in cells.into_iter().enumerate() {
        for row in own(cell) {
            let value = figure.of(row);
            figures.entry(row.seed).or_default()[side] = value.is_finite().then_some(value);
        }
    }
    let settings =
        cells.map(|cell| own(cell).next().map_or_else(String::new, |r| setting(&r.parameters)));
    let paired = Paired::of(&figures, LEVEL);
    CellPair { estimator: estimator.to_owned(), figure, cells, settings, paired }
}

impl fmt::Display for CellPair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, unit) = self.figure.words();
        let number = |value: f64| self.figure.number(value);
        writeln!(
            f,
            "{} {what}: A {} {unit}, B {} {unit}, over {} pairs of runs on the same seeds",
            self.estimator,
            number(self.paired.means[0]),
            number(self.paired.means[1]),
            self.paired.pairs
        )?;
        if self.paired.pairs == 0 {
            write!(f, "  no seed has this figure in both")?;
        } else if self.paired.pairs == 1 {
            write!(f, "  one pair has no interval: sweep more seeds")?;
        } else {
            let [paired, unpaired] =
                [self.paired.paired_half_width, self.paired.unpaired_half_width]
                    .map(|half| self.interval(half));
            writeln!(f, "  B − A  paired    {paired}")?;
            writeln!(f, "         unpaired  {unpaired}")?;
            write!(f, "         {}", self.gain())?;
        }
        for (name, missing) in ["A", "B"].iter().zip(&self.paired.missing) {
            if !missing.is_empty() {
                write!(f, "\n  {name} lacks {}", listed(missing))?;
            }
        }
        Ok(())
    }
}

impl CellPair {
    fn interval(&self, half_width: f64) -> String {
        let unit = self.figure.words().1;
        let number = |value: f64| self.figure.number(value);
        let (low, high) =
            (self.paired.difference - half_width, self.paired.difference + half_width);
        let verdict = if low <= 0.0 && high >= 0.0 { "  (no difference shown)" } else { "" };
        format!(
            "{:>9} {unit}, 95 % in [{}, {}]{verdict}",
            number(self.paired.difference),
            number(low),
            number(high)
        )
    }

    fn gain(&self) -> String {
        if self.paired.variance_reduction.is_infinite() || self.paired.variance_reduction.is_nan() {
            return "the differences have no spread".to_owned();
        }
        let Paired { variance_reduction, correlation, .. } = &self.paired;
        let correlation = match correlation.is_finite() {
            true => format!(" (correlation {correlation:.3})"),
            false => String::new(),
        };
        format!("the same noise for both saves {variance_reduction:.1}× the runs{correlation}")
    }
}

/// Seeds in words, the first few of many.
#[must_use]
pub fn listed(seeds: &[u64]) -> String {
    let shown: Vec<String> = seeds.iter().take(SHOWN).map(u64::to_string).collect();
    let more = seeds.len().saturating_sub(SHOWN);
    let word = if seeds.len() == 1 { "seed" } else { "seeds" };
    let tail = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{word} {}{tail}", shown.join(", "))
}

#[cfg(test)]
#[path = "paired_tests.rs"]
mod tests;
