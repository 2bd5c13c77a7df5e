//! What a bench reports on the page.

/// What a bench has to say on the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    /// Its heading.
    pub title: &'static str,
    /// What was measured and how to read the tables, in Markdown.
    pub about: String,
    /// The numbers.
    pub tables: Vec<Table>,
    /// What its goals come to.
    pub findings: Vec<Finding>,
}

/// A table; the first column says what a row is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// Headings.
    pub columns: Vec<&'static str>,
    /// As many cells each as there are columns.
    pub rows: Vec<Vec<String>>,
}

/// A goal and what was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// The name under which the notes speak of it.
    pub key: &'static str,
    /// What was aimed at.
    pub goal: &'static str,
    /// What was measured.
    pub found: String,
    /// Whether that is enough.
    pub met: bool,
}
