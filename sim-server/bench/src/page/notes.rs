//! What people wrote about the numbers.
//!
//! A Markdown file with a heading `## KEY` over each note, where KEY is the name
//! of a goal or of a bench. What stands before the first heading is about the
//! file itself and does not go on the page.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::error::PageError;

/// Notes by goal or bench.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Notes {
    path: String,
    by_key: BTreeMap<String, String>,
}

impl Notes {
    /// Those of a file; none if there is no such file.
    ///
    /// # Errors
    /// [`PageError::Io`] names the file.
    pub fn read(path: &Path) -> Result<Self, PageError> {
        match fs::read_to_string(path) {
            Ok(text) => Ok(Self { path: path.display().to_string(), ..Self::parse(&text) }),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(Self::default()),
            Err(e) => Err(PageError::io(path)(e)),
        }
    }

    /// Those of a text.
    #[must_use]
    pub fn parse(text: &str) -> Self {
        let text = format!("\n{text}");
        let note = |part: &str| {
            let (key, note) = part.split_once('\n').unwrap_or((part, ""));
            (key.trim().to_owned(), note.trim().to_owned())
        };
        let by_key = text.split("\n## ").skip(1).map(note).filter(|(_, note)| !note.is_empty());
        Self { path: String::new(), by_key: by_key.collect() }
    }

    /// The note on a goal or bench.
    #[must_use]
    pub fn on(&self, key: &str) -> Option<&str> {
        self.by_key.get(key).map(String::as_str)
    }

    /// Whether every note is about one of these.
    ///
    /// # Errors
    /// [`PageError::StrayNote`] names one that is not.
    pub fn check(&self, known: &[&str]) -> Result<(), PageError> {
        match self.by_key.keys().find(|key| !known.contains(&key.as_str())) {
            None => Ok(()),
            Some(key) => Err(PageError::StrayNote {
                path: self.path.clone(),
                key: key.clone(),
                known: known.join(", "),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# Notes\n\nHow to.\n\n## scan-noise\n\nThe logarithm.\n\n### more\n\nx\n\
                        ## scan\ny\n## empty\n\n";

    #[test]
    fn a_note_reaches_from_its_heading_to_the_next() {
        let notes = Notes::parse(TEXT);
        assert_eq!(notes.on("scan-noise"), Some("The logarithm.\n\n### more\n\nx"));
        assert_eq!(notes.on("scan"), Some("y"));
        assert_eq!(notes.on("empty"), None);
        assert_eq!(notes.on("Notes"), None);
    }

    #[test]
    fn a_note_about_nothing_is_found() {
        let notes = Notes::parse(TEXT);
        assert!(notes.check(&["scan", "scan-noise"]).is_ok());
        let error = notes.check(&["scan"]).unwrap_err().to_string();
        assert!(error.contains("\"scan-noise\""), "{error}");
    }
}
