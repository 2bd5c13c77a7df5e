//! Two settings on the same seeds: what common random numbers gain.
//!
//! Noise is placed by (seed, source, tick, beam), so the runs of one seed in two
//! cells meet the same noise, and what chance adds to one it adds to the other.
//! The difference is then taken seed by seed; [`Pairs`] says how, and what is
//! gained by it.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use rusty_contract::score::{degrees, metres};
use serde::Serialize;

use super::lines::setting;
use super::{Row, Swept};
use crate::statistics::Pairs;

/// Probability of the intervals.
const LEVEL: f64 = 0.95;
/// Seeds listed in a text before "and so many more".
const SHOWN: usize = 8;

/// A figure of one estimator in two cells, A and B.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Paired {
    /// Name in the roster.
    pub estimator: String,
    /// Which figure, with its unit.
    pub figure: Figure,
    /// Index of cell A, and of cell B.
    pub cells: [usize; 2],
    /// What is set in A, and in B.
    pub settings: [String; 2],
    /// Seeds that have a figure in both.
    pub pairs: usize,
    /// Mean over those seeds in A, and in B.
    pub means: [f64; 2],
    /// B − A, mean over the seeds.
    pub difference: f64,
    /// Half the width of its 95 % interval, seed by seed; NaN with fewer than
    /// two pairs.
    pub paired_half_width: f64,
    /// Half the width that two independent samples of this size and spread
    /// would have (Welch); NaN with fewer than two pairs.
    pub unpaired_half_width: f64,
    /// (unpaired over paired half width)²: how many times as many runs the
    /// unpaired comparison needs; infinite where the differences have no spread.
    pub variance_reduction: f64,
    /// Correlation of A and B over the seeds; NaN where one has no spread.
    pub correlation: f64,
    /// Seeds that are missing, or have no figure, in A; and in B.
    pub missing: [Vec<u64>; 2],
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
pub fn ab(swept: &Swept) -> Vec<Paired> {
    let first = (0..swept.cells.len()).step_by(2).filter(|a| a + 1 < swept.cells.len());
    first.flat_map(|a| paired(&swept.rows, [a, a + 1])).collect()
}

/// Both figures of every estimator, B less A, in the order in which estimators
/// first come in `rows`.
#[must_use]
pub fn paired(rows: &[Row], cells: [usize; 2]) -> Vec<Paired> {
    let mut names: Vec<&str> = Vec::new();
    for row in rows.iter().filter(|r| cells.contains(&r.cell)) {
        if !names.contains(&&*row.estimator) {
            names.push(&row.estimator);
        }
    }
    let figures = [Figure::FinalPositionErrorM, Figure::FinalHeadingErrorDeg];
    names
        .into_iter()
        .flat_map(|name| figures.map(|figure| compare(rows, cells, name, figure)))
        .collect()
}

fn compare(rows: &[Row], cells: [usize; 2], estimator: &str, figure: Figure) -> Paired {
    let own =
        |cell: usize| rows.iter().filter(move |r| r.cell == cell && *r.estimator == *estimator);
    let by_seed = cells.map(|cell| -> BTreeMap<u64, f64> {
        let figures = own(cell).map(|r| (r.seed, figure.of(r)));
        figures.filter(|(_, value)| value.is_finite()).collect()
    });
    let seeds = |cell: usize| own(cell).map(|r| r.seed);
    let every: BTreeSet<u64> = cells.into_iter().flat_map(seeds).collect();
    let missing = [0, 1]
        .map(|i| every.iter().copied().filter(|seed| !by_seed[i].contains_key(seed)).collect());
    let (a, b): (Vec<f64>, Vec<f64>) =
        by_seed[0].iter().filter_map(|(seed, a)| Some((*a, *by_seed[1].get(seed)?))).unzip();
    let pairs = Pairs::of(&a, &b, LEVEL);
    Paired {
        estimator: estimator.to_owned(),
        figure,
        cells,
        settings: cells
            .map(|cell| own(cell).next().map_or_else(String::new, |r| setting(&r.parameters))),
        pairs: pairs.n,
        means: pairs.means,
        difference: pairs.difference,
        paired_half_width: pairs.half_width,
        unpaired_half_width: pairs.unpaired_half_width,
        variance_reduction: pairs.variance_reduction,
        correlation: pairs.correlation,
        missing,
    }
}

impl fmt::Display for Paired {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, unit) = self.figure.words();
        let number = |value: f64| self.figure.number(value);
        writeln!(
            f,
            "{} {what}: A {} {unit}, B {} {unit}, over {} pairs of runs on the same seeds",
            self.estimator,
            number(self.means[0]),
            number(self.means[1]),
            self.pairs
        )?;
        if self.pairs < 2 {
            write!(f, "  one pair has no interval: sweep more seeds")?;
        } else {
            let [paired, unpaired] =
                [self.paired_half_width, self.unpaired_half_width].map(|half| self.interval(half));
            writeln!(f, "  B − A  paired    {paired}")?;
            writeln!(f, "         unpaired  {unpaired}")?;
            write!(f, "         {}", self.gain())?;
        }
        for (name, missing) in ["A", "B"].iter().zip(&self.missing) {
            if !missing.is_empty() {
                write!(f, "\n  {name} lacks {}", listed(missing))?;
            }
        }
        Ok(())
    }
}

impl Paired {
    fn interval(&self, half_width: f64) -> String {
        let unit = self.figure.words().1;
        let number = |value: f64| self.figure.number(value);
        let (low, high) = (self.difference - half_width, self.difference + half_width);
        let verdict = if low <= 0.0 && high >= 0.0 { "  (no difference shown)" } else { "" };
        format!(
            "{:>9} {unit}, 95 % in [{}, {}]{verdict}",
            number(self.difference),
            number(low),
            number(high)
        )
    }

    fn gain(&self) -> String {
        if self.variance_reduction.is_infinite() || self.variance_reduction.is_nan() {
            return "the differences have no spread".to_owned();
        }
        format!(
            "the same noise for both saves {:.1}× the runs (correlation {:.3})",
            self.variance_reduction, self.correlation
        )
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
