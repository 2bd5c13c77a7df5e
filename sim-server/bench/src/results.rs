//! The results of a benchmark: rows of named figures, and how they are shown.

use std::collections::BTreeMap;
use std::fmt::{Display, Formatter};

use rusty_contract::TextTable;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::quantiles::{Quantiles, Spread};

/// The results of a benchmark.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Settings, and figures of the benchmark as a whole.
    pub facts: BTreeMap<String, Value>,
    /// The columns of each table. A table shows the rows that have one of them.
    pub tables: Vec<Vec<Column>>,
    /// One for each case.
    pub rows: Vec<Row>,
}

/// A column: a figure of the rows.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Column {
    /// The name of the figure, with its unit.
    pub name: String,
    /// Digits after the point.
    pub digits: usize,
}

/// One case and its figures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The case.
    pub name: String,
    /// Figures by name; some may be in no table.
    #[serde(flatten)]
    pub figures: BTreeMap<String, Figure>,
}

/// A figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Figure {
    /// A count, or a duration in whole units.
    Integer(u64),
    /// A number.
    Number(f64),
    /// A number measured in several repetitions.
    Spread(Spread),
    /// A hash or a list.
    Text(String),
}

impl Results {
    /// Returns these rows, shown in tables with these columns: name and digits.
    pub fn new(tables: &[&[(&str, usize)]], rows: impl IntoIterator<Item = Row>) -> Self {
        let column = |&(name, digits): &(&str, usize)| Column { name: name.to_owned(), digits };
        let tables = tables.iter().map(|columns| columns.iter().map(column).collect());
        let (tables, rows) = (tables.collect(), rows.into_iter().collect());
        Self { facts: BTreeMap::new(), tables, rows }
    }

    /// Adds a fact.
    #[must_use]
    pub fn fact(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.facts.insert(name.to_owned(), value.into());
        self
    }

    /// Returns the rows of a table.
    pub fn rows_of<'a>(&'a self, columns: &'a [Column]) -> impl Iterator<Item = &'a Row> {
        let has_any = |row: &&Row| columns.iter().any(|c| row.figures.contains_key(&c.name));
        self.rows.iter().filter(has_any)
    }

    /// Returns all tables in Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let table = |columns: &Vec<Column>| markdown_table(&self.grid(columns, false));
        self.tables.iter().map(table).filter(|t| !t.is_empty()).collect::<Vec<_>>().join("\n")
    }

    /// Returns heading and rows of a table as cells; nothing if it has no rows.
    fn grid(&self, columns: &[Column], with_ranges: bool) -> Vec<Vec<String>> {
        let cell = |row: &Row, column: &Column| {
            let digits = column.digits;
            let number = |x: f64| format!("{x:.digits$}");
            match row.figures.get(&column.name) {
                None => "–".to_owned(),
                Some(Figure::Spread(s)) if with_ranges && column.has_range() => {
                    let [median, min, max] = [s.median, s.min, s.max].map(number);
                    format!("{median} ({min} to {max})")
                }
                Some(Figure::Text(text)) => text.clone(),
                Some(figure) => number(figure.number()),
            }
        };
        let mut grid: Vec<Vec<String>> = self
            .rows_of(columns)
            .map(|row| {
                let cells = columns.iter().map(|column| cell(row, column));
                std::iter::once(row.name.clone()).chain(cells).collect()
            })
            .collect();
        if !grid.is_empty() {
            let names = columns.iter().map(|column| column.name.clone());
            grid.insert(0, std::iter::once(String::new()).chain(names).collect());
        }
        grid
    }
}

impl Column {
    /// Whether a terminal shows least and greatest, too: ratios, and medians of
    /// repetitions.
    fn has_range(&self) -> bool {
        self.name.contains("over_") || self.name.contains("by_repetition")
    }
}

impl Row {
    /// Returns a row without figures.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), figures: BTreeMap::new() }
    }

    /// Adds a figure.
    #[must_use]
    pub fn with(mut self, name: &str, figure: impl Into<Figure>) -> Self {
        self.figures.insert(name.to_owned(), figure.into());
        self
    }

    /// Adds quantiles, ns, with `prefix` before their names.
    #[must_use]
    pub fn with_quantiles(self, prefix: &str, q: &Quantiles) -> Self {
        let name = |name: &str| format!("{prefix}{name}");
        self.with(&name("count"), q.count)
            .with(&name("mean_ns"), q.mean_ns)
            .with(&name("p50_ns"), q.p50_ns)
            .with(&name("p90_ns"), q.p90_ns)
            .with(&name("p99_ns"), q.p99_ns)
            .with(&name("p99_9_ns"), q.p99_9_ns)
            .with(&name("max_ns"), q.max_ns)
    }

    /// Returns the number of a figure, the median of a spread; NaN without one.
    #[must_use]
    pub fn number(&self, name: &str) -> f64 {
        self.figures.get(name).map_or(f64::NAN, Figure::number)
    }
}

impl Figure {
    fn number(&self) -> f64 {
        match self {
            Self::Integer(n) => *n as f64,
            Self::Number(x) => *x,
            Self::Spread(spread) => spread.median,
            Self::Text(_) => f64::NAN,
        }
    }
}

impl From<u64> for Figure {
    fn from(n: u64) -> Self {
        Self::Integer(n)
    }
}

impl From<usize> for Figure {
    fn from(n: usize) -> Self {
        Self::Integer(n as u64)
    }
}

impl From<f64> for Figure {
    fn from(x: f64) -> Self {
        Self::Number(x)
    }
}

impl From<Spread> for Figure {
    fn from(spread: Spread) -> Self {
        Self::Spread(spread)
    }
}

impl From<String> for Figure {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

/// Facts and tables for a terminal.
impl Display for Results {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let width = self.facts.keys().map(String::len).max().unwrap_or(0);
        for (name, value) in &self.facts {
            writeln!(f, "{name:width$}  {}", fact_text(value))?;
        }
        for columns in &self.tables {
            write!(f, "{}", text_table(self.grid(columns, true)))?;
        }
        Ok(())
    }
}

/// Returns a fact as text, a string without quotes.
#[must_use]
pub fn fact_text(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// Returns a table in Markdown; all columns but the first to the right.
#[must_use]
pub fn markdown_table(grid: &[Vec<String>]) -> String {
    let line = |cells: &Vec<String>| format!("| {} |\n", cells.join(" | "));
    let mut lines: Vec<String> = grid.iter().map(line).collect();
    if let Some(head) = grid.first() {
        lines.insert(1, format!("|---{}|\n", "|---:".repeat(head.len() - 1)));
    }
    lines.concat()
}

/// Returns a table for a terminal after an empty line; all columns but the first
/// to the right.
fn text_table(grid: Vec<Vec<String>>) -> String {
    let mut rows = grid.into_iter();
    let Some(heads) = rows.next() else { return String::new() };
    let mut table = TextTable::new(&heads.join("  >"));
    rows.for_each(|row| table.push(row));
    format!("\n{table}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn results() -> Results {
        let spread = Spread { median: 1.5, min: 1.25, max: 20.0 };
        let rows = [
            Row::new("one").with("p50_ns", 3478u64).with("over_raw", spread),
            Row::new("another").with("p50_ns", 17.25).with("calls", "2 (read)".to_owned()),
            Row::new("whole").with("hash", "00ff".to_owned()),
        ];
        Results::new(&[&[("p50_ns", 1), ("over_raw", 2)], &[("hash", 0)]], rows)
            .fact("wait", "balanced")
            .fact("ticks", 20)
    }

    #[test]
    fn a_terminal_shows_facts_and_aligned_tables() {
        let expected = "\
ticks  20
wait   balanced

         p50_ns              over_raw
one      3478.0  1.50 (1.25 to 20.00)
another    17.2                     –

       hash
whole  00ff
";
        assert_eq!(results().to_string(), expected);
    }

    #[test]
    fn a_page_shows_the_same_tables() {
        let expected = "\
|  | p50_ns | over_raw |
|---|---:|---:|
| one | 3478.0 | 1.50 |
| another | 17.2 | – |

|  | hash |
|---|---:|
| whole | 00ff |
";
        assert_eq!(results().markdown(), expected);
    }

    #[test]
    fn json_has_every_figure_under_its_name_and_is_read_back() {
        let json = serde_json::to_value(results()).unwrap();
        assert_eq!(json["rows"][0]["p50_ns"], 3478);
        assert_eq!(json["rows"][0]["over_raw"]["max"], 20.0);
        assert_eq!(json["rows"][1]["calls"], "2 (read)");
        assert_eq!(serde_json::from_value::<Results>(json).unwrap(), results());
        assert!(Row::new("x").number("p50_ns").is_nan());
    }
}
