//! Values in reports, scores and tables.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::repository;

/// The pages of the handbook, relative to the repository.
pub fn handbook_pages() -> Vec<String> {
    let folder = fs::read_dir(repository().join("docs")).unwrap().flatten();
    let names = folder.map(|entry| entry.file_name().into_string().unwrap());
    let pages = names.filter(|n| n.ends_with(".md")).map(|n| format!("docs/{n}"));
    let mut pages: Vec<String> = pages.collect();
    pages.sort();
    pages
}

/// A JSON file.
#[track_caller]
pub fn json_file(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// Text of a JSON value that must be a string.
#[track_caller]
pub fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or_else(|| panic!("{key} is no text in {value}"))
}

/// A number at a path of names and indices, separated by `/` or `.`.
#[track_caller]
pub fn number(value: &Value, path: &str) -> f64 {
    let pointer = format!("/{}", path.trim_start_matches('/').replace('.', "/"));
    let found = value.pointer(&pointer).and_then(Value::as_f64);
    found.unwrap_or_else(|| panic!("{path} is no number in {value}"))
}

/// The elements of a list of a document.
#[track_caller]
pub fn list<'a>(value: &'a Value, key: &str) -> &'a Vec<Value> {
    value[key].as_array().unwrap_or_else(|| panic!("{key} is no list in {value}"))
}

/// The element of a list with this name.
#[track_caller]
pub fn named<'a>(value: &'a Value, key: &str, name: &str) -> &'a Value {
    let found = list(value, key).iter().find(|element| element["name"] == name);
    found.unwrap_or_else(|| panic!("{key} has no {name} in {value}"))
}

/// The score of a participant in a report.
#[track_caller]
pub fn score_of<'a>(report: &'a Value, name: &str) -> &'a Value {
    named(report, "scores", name)
}

/// Scores, but for how long answers took, which is another time in every run.
#[track_caller]
pub fn timeless(scores: &Value) -> Value {
    let mut scores = scores.clone();
    let list = scores.as_array_mut().unwrap_or_else(|| panic!("no list of scores"));
    list.iter_mut().for_each(|score| score["compute"] = Value::Null);
    scores
}

/// A table of a CSV file.
pub struct Table {
    pub names: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Table {
    #[track_caller]
    pub fn read(path: &Path) -> Self {
        let mut reader = csv::Reader::from_path(path).unwrap();
        let words = |record: &csv::StringRecord| record.iter().map(str::to_owned).collect();
        let names = words(reader.headers().unwrap());
        Self { names, rows: reader.records().map(|r| words(&r.unwrap())).collect() }
    }

    #[track_caller]
    pub fn column(&self, name: &str) -> Vec<&str> {
        let at = self.names.iter().position(|n| n == name);
        let at = at.unwrap_or_else(|| panic!("no column {name} in {:?}", self.names));
        self.rows.iter().map(|row| row[at].as_str()).collect()
    }

    #[track_caller]
    pub fn numbers(&self, name: &str) -> Vec<f64> {
        self.column(name).iter().map(|v| v.parse().unwrap()).collect()
    }
}

/// Root mean square and 95th percentile of distances.
pub fn spread(mut distances_m: Vec<f64>) -> (f64, f64) {
    distances_m.sort_by(f64::total_cmp);
    let count = distances_m.len();
    let squares: f64 = distances_m.iter().map(|d| d * d).sum();
    ((squares / count as f64).sqrt(), distances_m[count * 95 / 100])
}
