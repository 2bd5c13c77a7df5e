//! The settings of a sweep as a document: what goes with its table, and what
//! must be the same for a sweep to go on.

use rusty_contract::{FieldError, JsonTree as _, RunConfig};
use rusty_geometry::WorldSpec;
use serde_json::{Map, Value, json};

use super::grid::{Axis, combinations};
use super::plan::Plan;
use super::program_files::program_files;
use super::seeds::Seeds;
use crate::documents;

/// The field of what was lost in the runs.
const LOST: &str = "lost";

/// The settings of a sweep. Nothing in it depends on the machine, the time or
/// the number of jobs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings(Map<String, Value>);

impl Settings {
    /// Those of `plan`, which `writer` carries out. Worlds stand once each, in a
    /// separate list; a cell's `world` is an index into it.
    ///
    /// # Errors
    /// [`FieldError`] if a configuration has no JSON, which checks exclude.
    pub fn of(plan: &Plan, writer: &str) -> Result<Self, FieldError> {
        let no_json = |e: serde_json::Error| {
            FieldError::new("the scenario", "", e.to_string(), "use numbers that are finite")
        };
        let mut worlds: Vec<&WorldSpec> = Vec::new();
        let mut cells = Vec::new();
        for cell in &plan.cells {
            let world = &cell.config.world;
            let index = worlds.iter().position(|w| *w == world).unwrap_or_else(|| {
                worlds.push(world);
                worlds.len() - 1
            });
            cells.push(cell_of(&cell.config, index).map_err(no_json)?);
        }
        let axes = plan.request.axes.iter();
        let parameters: Vec<Value> =
            axes.map(|a| json!({ "field": a.key, "values": a.values })).collect();
        let mut map = Map::new();
        map.insert("writer".to_owned(), json!(writer));
        map.insert("scenario".to_owned(), json!(plan.request.scenario));
        map.insert("seeds".to_owned(), json!(plan.request.seeds.to_string()));
        map.insert("parameters".to_owned(), json!(parameters));
        let rosters = serde_json::to_value(&plan.rosters).map_err(no_json)?;
        map.insert("rosters".to_owned(), rosters);
        let programs = program_files(&plan.rosters);
        if !programs.is_empty() {
            map.insert("programs".to_owned(), json!(programs));
        }
        map.insert("cells".to_owned(), json!(cells));
        map.insert("worlds".to_owned(), serde_json::to_value(&worlds).map_err(no_json)?);
        Ok(Self(map))
    }

    /// Whether its runs are made with clients.
    #[must_use]
    pub fn with_clients(&self) -> bool {
        self.0.get("rosters").and_then(Value::as_array).is_some_and(|r| !r.is_empty())
    }

    /// The number of runs of the sweep; `None` where the document is not ours.
    #[must_use]
    pub fn runs(&self) -> Option<u64> {
        let seeds: Seeds = self.0.get("seeds")?.as_str()?.parse().ok()?;
        seeds.count().checked_mul(self.0.get("cells")?.as_array()?.len() as u64)
    }

    /// Reads what [`text`](Self::text) or [`pretty`](Self::pretty) wrote.
    ///
    /// # Errors
    /// The parser's words.
    pub fn read(text: &[u8]) -> Result<Self, String> {
        serde_json::from_slice(text).map(Self).map_err(|e| e.to_string())
    }

    /// The document on one line.
    #[must_use]
    pub fn text(&self) -> String {
        Value::Object(self.0.clone()).to_string()
    }

    /// The document for people.
    #[must_use]
    pub fn pretty(&self) -> String {
        format!("{:#}\n", Value::Object(self.0.clone()))
    }

    /// Its parts: name and JSON text, in the order of the names.
    pub fn parts(&self) -> impl Iterator<Item = (&str, String)> {
        self.0.iter().map(|(name, value)| (name.as_str(), value.to_string()))
    }

    /// The document whose [`parts`](Self::parts) these are.
    #[must_use]
    pub fn from_parts<'a>(parts: impl Iterator<Item = (&'a str, &'a str)>) -> Self {
        let read = |text: &str| serde_json::from_str(text).unwrap_or(Value::Null);
        Self(parts.map(|(name, text)| (name.to_owned(), read(text))).collect())
    }

    /// The configuration of each setting, by what is set in it
    /// ([in words](words)): with its world, without the
    /// name of the scenario. Fewer where the document is not ours.
    #[must_use]
    pub fn configs(&self) -> Vec<(String, Value)> {
        let list = |name: &str| self.0.get(name).and_then(Value::as_array).into_iter().flatten();
        let axes = list("parameters").map(|axis| Axis {
            key: axis["field"].as_str().unwrap_or_default().to_owned(),
            values: axis["values"]
                .as_array()
                .into_iter()
                .flatten()
                .map(|v| v.as_str().unwrap_or_default().to_owned())
                .collect(),
        });
        let axes: Vec<Axis> = axes.collect();
        let all = combinations(&axes, usize::MAX).unwrap_or_default();
        let config = |cell: &Value| {
            let mut config = cell.clone();
            let world = config["world"].as_u64().unwrap_or(0) as usize;
            if let Some(fields) = config.as_object_mut() {
                fields.remove("scenario");
                let world = list("worlds").nth(world).cloned().unwrap_or_default();
                fields.insert("world".to_owned(), world);
            }
            config
        };
        let words = |set: &[(String, String)]| words(set.iter().map(|(k, v)| (&**k, &**v)));
        all.iter().zip(list("cells")).map(|(set, cell)| (words(set), config(cell))).collect()
    }

    /// Those of a sweep that is done: with the runs in which something was lost, seed and what.
    #[must_use]
    pub fn with_lost(mut self, lost: &[(u64, String)]) -> Self {
        if !lost.is_empty() {
            self.0.insert(LOST.to_owned(), json!(lost));
        }
        self
    }

    /// The runs in which something was lost.
    #[must_use]
    pub fn lost(&self) -> Vec<(u64, String)> {
        let list = self.0.get(LOST).cloned();
        list.and_then(|list| serde_json::from_value(list).ok()).unwrap_or_default()
    }

    /// The first field in which the two differ, and both values. What was lost is no setting.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Option<String> {
        let [a, b] = [self, other].map(|settings| {
            let mut fields = settings.0.clone();
            fields.remove(LOST);
            Value::Object(fields)
        });
        documents::differences(&a, &b).into_iter().next()
    }
}

/// A configuration without its seed, with its world by number.
fn cell_of(config: &RunConfig, world: usize) -> Result<Value, serde_json::Error> {
    let open = WorldSpec {
        name: String::new(),
        bounds: [0.0; 4],
        walls: Vec::new(),
        landmarks: Vec::new(),
    };
    let mut value = RunConfig { world: open, ..config.clone() }.to_tree()?;
    if let Some(fields) = value.as_object_mut() {
        fields.remove("seed");
        fields.insert("world".to_owned(), json!(world));
    }
    Ok(value)
}

/// What is set, in words that are the same however a number was written.
pub fn words<'a>(parameters: impl Iterator<Item = (&'a str, &'a str)>) -> String {
    let word = |(key, value): (&str, &str)| match value.parse::<f64>() {
        Ok(number) => format!("{key}={number}"),
        Err(_) => format!("{key}={value}"),
    };
    parameters.map(word).collect::<Vec<_>>().join(" ")
}
