//! What a sweep says in the end: the table, how the errors spread, what two
//! settings differ by; and the pictures.

use std::fmt;
use std::path::{Path, PathBuf};

use rusty_contract::replace;
use rusty_floorplan::map_server::beside;
use serde::Serialize;

use super::anees::Anees;
use super::error::SweepError;
use super::growth::Growth;
use super::overview::Overview;
use super::paired::CellPair;
use super::summary::SummaryRow;
use super::{AneesText, Bands, GrowthText, OverviewText, Summary, Swept, Table};
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

/// The drawings of a table.
const DRAWINGS: [&str; 3] = ["fan", "growth", "errors"];

/// A drawing next to the table at `out`, as SVG and as PNG: `STEM-fan.svg`.
fn drawing_files(out: &Path, name: &str) -> [PathBuf; 2] {
    let stem = out.with_extension("");
    ["svg", "png"].map(|ending| beside(&stem, &format!("-{name}.{ending}")))
}

/// The files of a sweep with this table: the table's, and those that [`draw`] makes.
pub fn results(table: &Table) -> impl Iterator<Item = PathBuf> {
    let drawings = DRAWINGS.into_iter().flat_map(|name| drawing_files(table.path(), name));
    table.files().into_iter().chain(drawings)
}

/// Draws the fan, the growth and the errors next to the table at `out`. Nothing of a
/// sweep without tracks. Says what was written.
///
/// # Errors
/// [`SweepError`] if the disk says no, or the drawing fails.
pub fn draw(swept: &Swept, out: &Path) -> Result<Vec<PathBuf>, SweepError> {
    if swept.tracks.is_empty() {
        return Ok(Vec::new());
    }
    let mut written = Vec::new();
    let drawn = [drawing::fan(swept), drawing::growth(swept), drawing::errors(swept)];
    for (name, svg) in DRAWINGS.into_iter().zip(drawn) {
        let paths = drawing_files(out, name);
        let failed = |e: rusty_plot::PlotError| SweepError::Table {
            path: paths[0].display().to_string(),
            problem: e.to_string(),
        };
        let png = rusty_plot::png(&svg).map_err(failed)?;
        for (path, bytes) in paths.into_iter().zip([svg.into_bytes(), png]) {
            replace(&path, &bytes).map_err(SweepError::io(&path))?;
            written.push(path);
        }
    }
    Ok(written)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_in_the_name_of_a_table_belong_to_its_drawings() {
        let files = drawing_files(Path::new("out/slip-0.35.csv"), "fan");
        let expected = ["out/slip-0.35-fan.svg", "out/slip-0.35-fan.png"].map(PathBuf::from);
        assert_eq!(files, expected);
    }
}
