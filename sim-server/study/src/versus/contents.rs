//! The runs in a sweep's table, and what was set in them.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;

use super::error::VersusError;
use super::metric::Metric;
use crate::sweep::Table;
use crate::sweep::settings::{Settings, words};

/// One run of one estimator.
#[derive(Clone, Debug)]
pub struct Run {
    /// The seed of all noise.
    pub seed: u64,
    /// Index of what is set, in [`Contents::settings`].
    pub setting: usize,
    /// Index of the name, in [`Contents::estimators`].
    pub estimator: usize,
    /// Complete ticks.
    pub ticks: u64,
    /// Distance truly driven, m; NaN where nothing was scored.
    pub distance_m: f64,
    /// Figures in the order of [`Metric::ALL`]; NaN where there is none.
    pub figures: [f64; Metric::ALL.len()],
}

/// What is in a table.
#[derive(Clone, Debug)]
pub struct Contents {
    /// The file.
    pub path: String,
    /// The estimators, in the order in which they first come.
    pub estimators: Vec<String>,
    /// What is set, in words (empty where nothing was swept), in the order in
    /// which they first come.
    pub settings: Vec<String>,
    /// A row each.
    pub runs: Vec<Run>,
    /// Configurations by the same words, without seed and name; `None` where the
    /// file has none next to it.
    pub configs: Option<Vec<(String, Value)>>,
}

impl Contents {
    /// Reads a table.
    ///
    /// # Errors
    /// [`VersusError`] if it is none of a sweep.
    pub fn read(path: &Path) -> Result<Self, VersusError> {
        let shown = path.display().to_string();
        let no_table = |problem: String| VersusError::NoTable { path: shown.clone(), problem };
        let table = Table::at(path)
            .map_err(|_| no_table("is called neither FILE.csv nor FILE.parquet".to_owned()))?;
        let rows = table.rows()?;
        let columns = Columns::of(&rows.names).map_err(no_table)?;
        let document = match table.settings() {
            Ok(document) => document,
            // A CSV file may have been moved without what is next to it.
            Err(_) if !table.files().iter().all(|file| file.exists()) => None,
            Err(e) => return Err(e.into()),
        };
        let configs = document.as_ref().map(Settings::configs);
        let (estimators, settings) = (Vec::new(), Vec::new());
        let mut contents =
            Self { path: shown.clone(), estimators, settings, runs: Vec::new(), configs };
        let mut places = BTreeSet::new();
        for row in rows {
            let run = columns.run(&row?, &mut contents).map_err(no_table)?;
            if !places.insert((run.setting, run.seed, run.estimator)) {
                return Err(no_table(format!("has seed {} of an estimator twice", run.seed)));
            }
            contents.runs.push(run);
        }
        let runs: BTreeSet<_> = contents.runs.iter().map(|run| (run.setting, run.seed)).collect();
        match document.and_then(|document| document.runs()) {
            Some(planned) if planned != runs.len() as u64 => {
                let count = runs.len();
                Err(no_table(format!("has {count} of the {planned} runs of its sweep")))
            }
            _ => Ok(contents),
        }
    }

    /// The estimators, in words.
    #[must_use]
    pub fn names(&self) -> String {
        self.estimators.join(", ")
    }
}

/// Where what is in a row.
struct Columns {
    seed: usize,
    estimator: usize,
    ticks: usize,
    distance_m: usize,
    figures: [Option<usize>; Metric::ALL.len()],
    /// The swept fields, with their names.
    swept: Vec<(usize, String)>,
}

impl Columns {
    fn of(names: &[String]) -> Result<Self, String> {
        let at = |name: &str| names.iter().position(|n| n == name);
        let must = |name: &str| at(name).ok_or_else(|| format!("has no column {name:?}"));
        let (seed, estimator) = (must("seed")?, must("estimator")?);
        // Fields that were swept stand between the two.
        let swept = names.iter().enumerate().take(estimator).skip(seed + 1);
        let name = |name: &str| name.strip_prefix("set.").unwrap_or(name).to_owned();
        Ok(Self {
            seed,
            estimator,
            ticks: must("ticks")?,
            distance_m: must("distance_m")?,
            figures: Metric::ALL.map(|m| at(m.column())),
            swept: swept.map(|(i, n)| (i, name(n))).collect(),
        })
    }

    fn run(&self, row: &[String], contents: &mut Contents) -> Result<Run, String> {
        let text = |at: usize| row.get(at).map_or("", String::as_str);
        let wrong = |at: usize| format!("holds {:?} where a number belongs", text(at));
        let whole = |at: usize| text(at).parse::<u64>().map_err(|_| wrong(at));
        let number = |at: usize| match text(at) {
            "" => Ok(f64::NAN),
            word => word.parse::<f64>().map_err(|_| wrong(at)),
        };
        let mut figures = [f64::NAN; Metric::ALL.len()];
        for ((figure, at), metric) in figures.iter_mut().zip(&self.figures).zip(Metric::ALL) {
            if let Some(at) = at {
                *figure = metric.of(number(*at)?);
            }
        }
        let parameters = self.swept.iter().map(|(at, name)| (name.as_str(), text(*at)));
        Ok(Run {
            seed: whole(self.seed)?,
            setting: place(&mut contents.settings, words(parameters)),
            estimator: place(&mut contents.estimators, text(self.estimator).to_owned()),
            ticks: whole(self.ticks)?,
            distance_m: number(self.distance_m)?,
            figures,
        })
    }
}

/// The index of a text in a list that it is added to if need be. Rows come in
/// order: it is near the end, if at all.
fn place(list: &mut Vec<String>, text: String) -> usize {
    list.iter().rposition(|t| *t == text).unwrap_or_else(|| {
        list.push(text);
        list.len() - 1
    })
}
