//! `bench page`: the page of all benches, made from their documents.
//!
//! * [`benches`]: which benches are on it;
//! * [`documents`]: what they measured, kept in a file beside the page, so that
//!   the page can be made again without measuring;
//! * [`notes`]: what people wrote about it, kept in another file;
//! * [`markdown`]: the page;
//! * [`peers`]: the section of a bench that is another program's.
//!
//! A number stands on the page because a bench printed it, and a goal is met or
//! missed by what it says; only the explanations are written by hand.

pub mod benches;
pub mod documents;
pub mod error;
pub mod markdown;
pub mod notes;
pub mod peers;

pub use benches::BENCHES;
pub use documents::Documents;
pub use error::PageError;
pub use notes::Notes;

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
