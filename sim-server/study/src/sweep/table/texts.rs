//! Rows as texts.

/// Rows, or the library's words.
pub(super) type Texts = Box<dyn Iterator<Item = Result<Vec<String>, String>>>;
