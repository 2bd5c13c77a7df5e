//! A result compared with the same runs made again.

use serde::Serialize;
use serde_json::{Map, Value};

use super::block::blocks;
use super::entry::Entry;
use super::error::BenchmarkError;
use super::result::BenchmarkResult;
use super::run::BenchmarkRun;
use super::selection::{Selection, Wanted};
use super::suite::Suite;
use crate::documents::differences;

/// The outcome of comparing a result with the same runs made again.
#[derive(Clone, Debug, Serialize)]
pub struct Verification {
    /// Whether every digest, figure, score and verdict that was checked is equal.
    pub is_equal: bool,
    /// Runs that were made again.
    pub runs: usize,
    /// Entries whose runs were made again.
    pub checked: Vec<String>,
    /// Entries whose runs were not: no program was given. Their scores and verdicts were
    /// computed again from the figures in the file.
    pub unchecked: Vec<String>,
    /// Fields that differ, with the value of the file and the one expected.
    pub differences: Vec<String>,
}

/// Returns the entries of a result whose runs can be made again: the baselines, as this
/// program has them, and those in `added`.
#[must_use]
pub fn checkable(result: &BenchmarkResult, suite: &Suite, added: Vec<Entry>) -> Vec<Entry> {
    let known = added.into_iter().chain(Entry::baselines(suite));
    known.filter(|entry| result.entries.iter().any(|e| e.name == entry.name)).collect()
}

/// Compares a result with the runs of the entries `checked`, made again. Compute times,
/// machine, commands and the wording of failures may differ.
///
/// # Errors
/// [`BenchmarkError`] if a result cannot be written as JSON.
pub fn verify(
    result: &BenchmarkResult,
    suite: &Suite,
    checked: &[Entry],
    made: Vec<BenchmarkRun>,
) -> Result<Verification, BenchmarkError> {
    let is_checked = |name: &str| checked.iter().any(|entry| entry.name == name);
    let count = made.len();
    let mut runs = made;
    runs.extend(result.runs.iter().filter(|run| !is_checked(&run.entry)).cloned());
    let rest = (result.confined, result.writer.clone(), result.machine.clone());
    // Baselines that the suite has and the file lacks are missing runs.
    let mut entries = result.entries.clone();
    let missing = Entry::baselines(suite).into_iter();
    entries.extend(missing.filter(|b| !result.entries.iter().any(|e| e.name == b.name)));
    let Selection { scenarios: only, tracks, seeds, key, recordings, .. } =
        result.selection.clone();
    let wanted = Wanted { only, tracks, seeds: Some(seeds), key, recordings };
    let selection = Selection::of(suite, wanted)?;
    let expected = BenchmarkResult::of(suite, selection, entries, runs, rest)?;
    let mut found = differences(&comparable(result)?, &comparable(&expected)?);
    found.extend(miscounted(result, suite, &expected)?);
    let names = |is_wanted: bool| {
        let own = result.entries.iter().filter(|e| is_checked(&e.name) == is_wanted);
        own.map(|e| e.name.clone()).collect()
    };
    Ok(Verification {
        is_equal: found.is_empty(),
        runs: count,
        checked: names(true),
        unchecked: names(false),
        differences: found,
    })
}

/// Runs of entries that were not made again and that a result has not exactly once.
fn miscounted(
    result: &BenchmarkResult,
    suite: &Suite,
    expected: &BenchmarkResult,
) -> Result<Vec<String>, BenchmarkError> {
    let mut found = Vec::new();
    for block in blocks(suite, &expected.selection, &expected.entries) {
        let (scenario, entry) = (&block.scenario.name, &block.entry.name);
        for seed in expected.selection.seeds_of(block.scenario)? {
            let is_it = |run: &&BenchmarkRun| {
                (run.seed, run.map) == (seed, block.map)
                    && (&run.scenario, &run.entry) == (scenario, entry)
            };
            let there = result.runs.iter().filter(is_it).count();
            if there != 1 && expected.runs.iter().filter(is_it).count() == there {
                let map = super::track::map_word(block.map);
                found.push(format!("runs.{scenario}/{map}/{entry}/{seed}: {there} runs and 1"));
            }
        }
    }
    Ok(found)
}

/// A result with lists as objects, so that a difference names its place, and without what
/// may differ.
fn comparable(result: &BenchmarkResult) -> Result<Value, BenchmarkError> {
    let mut value = serde_json::to_value(result).map_err(BenchmarkError::Json)?;
    let Some(fields) = value.as_object_mut() else { return Ok(value) };
    for field in ["machine", "writer"] {
        fields.remove(field);
    }
    for (list, names) in [
        ("entries", &["name"][..]),
        ("runs", &["scenario", "map", "entry", "seed"]),
        ("scores", &["scenario", "track", "entry", "metric"]),
        ("verdicts", &["scenario", "track", "entry", "baseline", "metric"]),
    ] {
        let Some(Value::Array(items)) = fields.remove(list) else { continue };
        let mut keyed = Map::new();
        for mut item in items {
            let key: Vec<String> = names.iter().map(|name| word(&item[*name])).collect();
            let mut key = key.join("/");
            if let Some(item) = item.as_object_mut() {
                for field in ["compute_p50_s", "compute_p99_s", "command"] {
                    item.remove(field);
                }
                // Their places differ from machine to machine, their number does not.
                if let Some(files) = item.get_mut("files") {
                    *files = files.as_array().map_or(0, Vec::len).into();
                }
                if let Some(failure) = item.get_mut("failure") {
                    *failure = Value::Bool(!failure.is_null());
                }
            }
            // Two of the same name are both compared.
            while keyed.contains_key(&key) {
                key.push('+');
            }
            keyed.insert(key, item);
        }
        fields.insert(list.to_owned(), Value::Object(keyed));
    }
    Ok(value)
}

fn word(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}
