//! The lines of tables for people: their keys, and the columns that all begin with.

/// The columns that all tables for people begin with: setting and estimator.
pub(super) struct Whose {
    /// What is set in each line.
    pub names: Vec<String>,
    /// Width of that column.
    pub width: usize,
    /// Width of the estimators'.
    pub name: usize,
}

impl Whose {
    /// For lines of these swept fields and estimators.
    pub fn of<'l>(lines: impl Iterator<Item = (&'l [(String, String)], &'l str)>) -> Self {
        let wider = |width: usize, word: &str| width.max(word.chars().count());
        let mut whose = Self { names: Vec::new(), width: 7, name: 9 };
        for (parameters, estimator) in lines {
            let words = setting(parameters);
            whose.width = wider(whose.width, &words);
            whose.name = wider(whose.name, estimator);
            whose.names.push(words);
        }
        whose
    }
}

/// A cell's swept fields on one line.
#[must_use]
pub fn setting(parameters: &[(String, String)]) -> String {
    if parameters.is_empty() {
        return "–".to_owned();
    }
    let words: Vec<String> =
        parameters.iter().map(|(key, value)| format!("{key}={value}")).collect();
    words.join(" ")
}

/// Each key once, in the order in which they first come.
pub(super) fn in_order<K: PartialEq>(keys: impl Iterator<Item = K>) -> Vec<K> {
    let mut found = Vec::new();
    for key in keys {
        // Rows come cell by cell: a known key is near the end.
        if !found.iter().rev().any(|known| *known == key) {
            found.push(key);
        }
    }
    found
}
