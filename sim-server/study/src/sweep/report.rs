//! What a sweep says in the end: the table, how the errors spread, what two
//! settings differ by; and the pictures.

use std::fmt;
use std::path::{Path, PathBuf};

use rusty_contract::output;
use serde::Serialize;

use super::anees::Anees;
use super::error::SweepError;
use super::growth::Growth;
use super::overview::Overview;
use super::paired::CellPair;
use super::summary::SummaryRow;
use super::{AneesText, Bands, GrowthText, OverviewText, Summary, Swept};
use super::{ab, anees, drawing, growth, overview, summary};

/// What a sweep says.
#[derive(Debug, Serialize)]
pub struct Report {
    /// A line for each estimator in each cell.
    pub table: Vec<SummaryRow>,
    /// How their errors spread; of each that was followed along the way.
    pub growth: Vec<Growth>,
    /// Whether their covariances are right, of runs with clients.
    pub consistency: Vec<Anees>,
    /// All of it that one asks for first, of runs with clients.
    pub overview: Vec<Overview>,
    /// Differences of two cells that share every seed, where asked for.
    pub paired: Vec<CellPair>,
}

impl Report {
    /// The report of a complete sweep. Where the last swept field has two values
    /// to be `compared`, neighbouring cells are.
    #[must_use]
    pub fn of(swept: &Swept, compared: bool) -> Self {
        let consistency = anees(swept);
        Self {
            table: summary(&swept.rows),
            growth: growth(&swept.tracks),
            overview: overview(swept, &consistency),
            consistency,
            paired: if compared { ab(swept) } else { Vec::new() },
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}\n\n{}\n", Summary(&self.table), Bands(&self.table))?;
        if !self.growth.is_empty() {
            writeln!(f, "\n{}", GrowthText(&self.growth))?;
        }
        if !self.consistency.is_empty() {
            writeln!(f, "\n{}", AneesText(&self.consistency))?;
        }
        if !self.overview.is_empty() {
            writeln!(f, "\n{}", OverviewText(&self.overview))?;
        }
        self.paired.iter().try_for_each(|pair| write!(f, "\n{pair}"))
    }
}

/// Draws the fan and the growth next to the table at `out`: `STEM-fan.svg`,
/// `STEM-growth.svg` and both as PNG. Nothing of a sweep without tracks. Says
/// what was written.
///
/// # Errors
/// [`SweepError`] if the disk says no, or the drawing fails.
pub fn draw(swept: &Swept, out: &Path) -> Result<Vec<PathBuf>, SweepError> {
    if swept.tracks.is_empty() {
        return Ok(Vec::new());
    }
    let mut written = Vec::new();
    for (name, svg) in [
        ("fan", drawing::fan(swept)),
        ("growth", drawing::growth(swept)),
        ("errors", drawing::errors(swept)),
    ] {
        let mut stem = out.file_stem().unwrap_or_default().to_owned();
        stem.push(format!("-{name}"));
        let path = |ending: &str| out.with_file_name(&stem).with_extension(ending);
        let failed = |e: rusty_plot::PlotError| SweepError::Table {
            path: path("svg").display().to_string(),
            problem: e.to_string(),
        };
        let png = rusty_plot::png(&svg).map_err(failed)?;
        for (path, bytes) in [(path("svg"), svg.into_bytes()), (path("png"), png)] {
            output::write(&path, &bytes).map_err(SweepError::io(&path))?;
            written.push(path);
        }
    }
    Ok(written)
}
