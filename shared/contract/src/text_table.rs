//! `TextTable`: a table for people, as text.

use std::fmt::{Display, Formatter, Result};

/// A table as text: columns as wide as their widest cell, two spaces between
/// them. A column in which no row has anything is left out.
#[derive(Clone, Debug, Default)]
pub struct TextTable {
    /// Each with whether its column is aligned to the right.
    heads: Vec<(String, bool)>,
    rows: Vec<Vec<String>>,
}

impl TextTable {
    /// A table without rows. The heads are two spaces apart; one that begins with
    /// `>` is of a column aligned to the right.
    #[must_use]
    pub fn new(heads: &str) -> Self {
        let head = |text: &str| match text.strip_prefix('>') {
            Some(text) => (text.to_owned(), true),
            None => (text.to_owned(), false),
        };
        Self { heads: heads.split("  ").map(head).collect(), rows: Vec::new() }
    }

    /// Adds a row. One of fewer cells than there are columns ends with a remark,
    /// which is as long as it is.
    pub fn row(&mut self, cells: &[&dyn Display]) {
        self.push(cells.iter().map(ToString::to_string).collect());
    }

    /// As [`TextTable::row`], with cells that are texts already.
    pub fn push(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    /// The width of a column; 0 if no row has anything in it.
    fn width(&self, column: usize) -> usize {
        let is_cell = |row: &&Vec<String>| column + 1 < row.len() || row.len() == self.heads.len();
        let cells = self.rows.iter().filter(is_cell).filter_map(|row| row.get(column));
        let widest = cells.map(|cell| cell.chars().count()).max().unwrap_or(0);
        let is_used = widest > 0 || self.rows.is_empty();
        if is_used { widest.max(self.heads[column].0.chars().count()) } else { 0 }
    }
}

impl Display for TextTable {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let widths: Vec<usize> = (0..self.heads.len()).map(|column| self.width(column)).collect();
        let heads: Vec<String> = self.heads.iter().map(|(head, _)| head.clone()).collect();
        for (k, row) in std::iter::once(&heads).chain(&self.rows).enumerate() {
            let mut line = String::new();
            for (column, cell) in row.iter().enumerate() {
                let is_remark = column + 1 == row.len() && row.len() < widths.len();
                match widths[column] {
                    _ if is_remark => line.push_str(cell),
                    0 => continue,
                    width if self.heads[column].1 => line.push_str(&format!("{cell:>width$}")),
                    width => line.push_str(&format!("{cell:width$}")),
                }
                line.push_str("  ");
            }
            write!(f, "{}{}", if k > 0 { "\n" } else { "" }, line.trim_end())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_they_must_be() {
        let mut table = TextTable::new("name  >m  >none  >°  state");
        assert_eq!(table.to_string(), "name  m  none  °  state");
        table.row(&[&"σ", &1.5, &"", &10, &"ok"]);
        table.row(&[&"longer", &"nothing was scored in this run"]);
        table.row(&[&"b", &-0.25, &"", &7, &""]);
        let expected = "name        m   °  state\n\
                        σ         1.5  10  ok\n\
                        longer  nothing was scored in this run\n\
                        b       -0.25   7";
        assert_eq!(table.to_string(), expected);
    }
}
