//! The table of a sweep on disk: a row per run and estimator.

mod columns;
mod csv;
mod parquet;
mod read;
mod texts;

pub use read::Rows;

use std::path::{Path, PathBuf};

use rusty_contract::{FieldError, input, replace};

use super::cell::Swept;
use super::error::SweepError;
use super::grid::Axis;
use super::settings::Settings;

/// A file that a table goes to; its ending says how.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    path: PathBuf,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Csv,
    Parquet,
}

impl Table {
    /// The table at `path`, by its ending.
    ///
    /// # Errors
    /// [`FieldError`] says which endings there are.
    pub fn at(path: &Path) -> Result<Self, FieldError> {
        let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
        let kind = match ending.to_str() {
            Some("csv") => Kind::Csv,
            Some("parquet") => Kind::Parquet,
            _ => {
                let remedy = "call it FILE.parquet or FILE.csv";
                return Err(FieldError::new(
                    "--out",
                    path.display(),
                    "has no ending known",
                    remedy,
                ));
            }
        };
        Ok(Self { path: path.to_owned(), kind })
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file with `ending` after its name: `FILE.csv.part`.
    #[must_use]
    pub fn beside(&self, ending: &str) -> PathBuf {
        rusty_floorplan::map_server::beside(&self.path, ending)
    }

    /// The files that [`write`](Self::write) makes.
    #[must_use]
    pub fn files(&self) -> Vec<PathBuf> {
        match self.kind {
            Kind::Csv => vec![self.path.clone(), self.beside(".json")],
            Kind::Parquet => vec![self.path.clone()],
        }
    }

    /// Writes rows and settings; the same bytes for the same of both. The file
    /// is there when it is complete. A CSV file has its settings next to it, in
    /// `FILE.csv.json`, a Parquet file in its key-value metadata as `rusty.…`.
    ///
    /// # Errors
    /// [`SweepError`] if the disk says no.
    pub fn write(
        &self,
        swept: &Swept,
        axes: &[Axis],
        settings: &Settings,
    ) -> Result<(), SweepError> {
        let columns = columns::of(swept, axes, settings.with_clients());
        let bytes = match self.kind {
            Kind::Csv => {
                let beside = self.beside(".json");
                replace(&beside, settings.pretty().as_bytes()).map_err(SweepError::io(&beside))?;
                csv::bytes(&columns)
            }
            Kind::Parquet => parquet::bytes(&columns, settings),
        };
        let path = || self.path.display().to_string();
        let bytes = bytes.map_err(|problem| SweepError::Table { path: path(), problem })?;
        replace(&self.path, &bytes).map_err(SweepError::io(&self.path))
    }

    /// The settings of the table that is there; `None` if none is.
    ///
    /// # Errors
    /// [`SweepError`] if what is there is no table of a sweep.
    pub fn settings(&self) -> Result<Option<Settings>, SweepError> {
        if !self.path.exists() {
            return Ok(None);
        }
        let found = match self.kind {
            Kind::Csv => {
                let beside = input::read(&self.beside(".json")).map_err(|e| e.to_string());
                beside.and_then(|text| Settings::read(&text))
            }
            Kind::Parquet => parquet::settings(&self.path),
        };
        let path = self.path.display().to_string();
        let no_sweep =
            |e| SweepError::NoSweep { path, problem: format!("its settings cannot be read: {e}") };
        found.map(Some).map_err(no_sweep)
    }
}
