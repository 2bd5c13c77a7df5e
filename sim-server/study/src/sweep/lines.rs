//! The words for a setting.

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
