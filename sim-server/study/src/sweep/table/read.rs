//! A table again, row by row, whatever its ending.

use super::texts::Texts;
use super::{Kind, Table, csv, parquet};
use crate::sweep::error::SweepError;

/// The rows of a table as texts, as a CSV file has them: numbers read back to
/// the same bits, nothing where a value is not known.
pub struct Rows {
    /// The columns.
    pub names: Vec<String>,
    path: String,
    rows: Texts,
}

impl Table {
    /// The rows of the table that is there.
    ///
    /// # Errors
    /// [`SweepError`] if there is none, or what is there is none.
    pub fn rows(&self) -> Result<Rows, SweepError> {
        let read = match self.kind {
            Kind::Csv => csv::rows(&self.path),
            Kind::Parquet => parquet::rows(&self.path),
        };
        let path = self.path.display().to_string();
        let (names, rows) =
            read.map_err(|problem| SweepError::Unreadable { path: path.clone(), problem })?;
        Ok(Rows { names, path, rows })
    }
}

impl Iterator for Rows {
    type Item = Result<Vec<String>, SweepError>;

    fn next(&mut self) -> Option<Self::Item> {
        let row = self.rows.next()?;
        let path = || self.path.clone();
        Some(row.map_err(|problem| SweepError::Unreadable { path: path(), problem }))
    }
}
