//! Tables of a page, each with the commands before it.

/// A table of figures.
pub struct Table {
    /// The heading of its section and its number in the section, from 0.
    pub place: (String, usize),
    /// The commands of the last `sh` block of the section before it.
    pub commands: Vec<String>,
    pub headings: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// Returns the tables of a page in Markdown.
    pub fn all(page: &str) -> Vec<Self> {
        let (mut found, mut block) = (Vec::<Self>::new(), String::new());
        let (mut section, mut is_code, mut is_table) = ("", false, false);
        for line in page.lines() {
            if line == "```sh" {
                (is_code, block) = (true, String::new());
            } else if line.starts_with("```") {
                is_code = false;
            } else if is_code {
                block += &format!("{line}\n");
            } else if let Some(heading) = ["# ", "## "].iter().find_map(|m| line.strip_prefix(m)) {
                section = heading;
                block.clear();
            }
            let is_row = !is_code && line.starts_with('|');
            if is_row && is_table {
                found.last_mut().unwrap().rows.push(cells(line));
            } else if is_row {
                let before = found.iter().filter(|table| table.place.0 == section);
                let place = (section.to_owned(), before.count());
                let commands = block.replace("\\\n", " ").lines().map(str::to_owned).collect();
                found.push(Self { place, commands, headings: cells(line), rows: Vec::new() });
            }
            is_table = is_row;
        }
        // The first row is the line of dashes.
        found.iter_mut().for_each(|table| drop(table.rows.remove(0)));
        found
    }

    /// Returns a heading; one that continues the heading before it has both.
    pub fn heading(&self, column: usize) -> String {
        match self.headings[column].as_str() {
            more if more.starts_with("after") => format!("{}, {more}", self.headings[column - 1]),
            heading => heading.to_owned(),
        }
    }

    /// Returns a row as a line of the page.
    pub fn line(cells: &[String]) -> String {
        format!("| {} |", cells.join(" | "))
    }
}

fn cells(line: &str) -> Vec<String> {
    let inner = line.trim_start_matches('|').trim_end_matches('|');
    inner.split('|').map(|cell| cell.trim().to_owned()).collect()
}
