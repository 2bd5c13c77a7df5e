//! The table as CSV: a line of names, then a line per row.

use std::path::Path;

use rusty_contract::input;

use super::columns::{Column, Values};
use super::texts::Texts;

/// The file's bytes. Numbers are as short as they can be and still read back to
/// the same bits; `NaN` where there was nothing to score, and nothing where a
/// value is not known.
///
/// # Errors
/// The library's words.
pub(super) fn bytes(columns: &[Column]) -> Result<Vec<u8>, String> {
    let words = |e: csv::Error| e.to_string();
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(columns.iter().map(|c| &c.name)).map_err(words)?;
    let rows = columns.first().map_or(0, |c| c.values.len());
    for row in 0..rows {
        writer.write_record(columns.iter().map(|c| c.values.text(row))).map_err(words)?;
    }
    writer.into_inner().map_err(|e| e.to_string())
}

/// The names and rows of a file.
///
/// # Errors
/// The library's words.
pub(super) fn rows(path: &Path) -> Result<(Vec<String>, Texts), String> {
    let texts = |record: csv::StringRecord| record.iter().map(str::to_owned).collect();
    let mut reader = csv::Reader::from_reader(input::open(path).map_err(|e| e.to_string())?);
    let names = texts(reader.headers().map_err(|e| e.to_string())?.clone());
    let rows = reader.into_records().map(move |row| row.map(texts).map_err(|e| e.to_string()));
    Ok((names, Box::new(rows)))
}

impl Values {
    fn len(&self) -> usize {
        match self {
            Self::Whole(v) => v.len(),
            Self::Signed(v) => v.len(),
            Self::Number(v) => v.len(),
            Self::Flag(v) => v.len(),
            Self::Text(v) => v.len(),
            Self::Known(v) => v.len(),
        }
    }

    fn text(&self, row: usize) -> String {
        match self {
            Self::Whole(v) => v[row].to_string(),
            Self::Signed(v) => v[row].to_string(),
            Self::Number(v) => format!("{:?}", v[row]),
            Self::Flag(v) => v[row].to_string(),
            Self::Text(v) => v[row].clone(),
            Self::Known(v) => v[row].map_or_else(String::new, |n| n.to_string()),
        }
    }
}
