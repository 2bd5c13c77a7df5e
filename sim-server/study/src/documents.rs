//! Two JSON documents, field by field.

use std::fmt;

use serde_json::Value;
use serde_json::Value::{Array, Object};

/// A field in which two documents differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Its path, as `world.walls[3].a`.
    pub path: String,
    /// What both have there, in brief.
    pub values: [String; 2],
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { path, values: [a, b] } = self;
        write!(f, "{path}: {a} and {b}")
    }
}

/// The fields in which two documents differ, as texts: path and both values.
#[must_use]
pub fn differences(a: &Value, b: &Value) -> Vec<String> {
    differing(a, b).iter().map(Difference::to_string).collect()
}

/// The fields in which two documents differ.
#[must_use]
pub fn differing(a: &Value, b: &Value) -> Vec<Difference> {
    let mut found = Vec::new();
    walk("", a, b, &mut found);
    found
}

fn walk(path: &str, a: &Value, b: &Value, found: &mut Vec<Difference>) {
    let inside = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match (a, b) {
        _ if a == b => {}
        (Object(x), Object(y)) => {
            for key in x.keys().chain(y.keys().filter(|k| !x.contains_key(*k))) {
                let missing = Value::Null;
                let (x, y) = (x.get(key).unwrap_or(&missing), y.get(key).unwrap_or(&missing));
                walk(&inside(key), x, y, found);
            }
        }
        (Array(x), Array(y)) if x.len() == y.len() => {
            for (i, (x, y)) in x.iter().zip(y).enumerate() {
                walk(&format!("{path}[{i}]"), x, y, found);
            }
        }
        _ => found.push(Difference { path: path.to_owned(), values: [brief(a), brief(b)] }),
    }
}

/// The longest value that is shown whole, characters of JSON.
const SHOWN_WHOLE: usize = 80;

/// A value on one line: a long list or object (the walls of a world, say) by what
/// it has.
fn brief(value: &Value) -> String {
    let whole = value.to_string();
    match value {
        _ if whole.chars().count() <= SHOWN_WHOLE => whole,
        Array(items) => format!("a list of {}", items.len()),
        Object(fields) => {
            let names: Vec<&str> = fields.keys().map(String::as_str).collect();
            format!("an object with {}", names.join(", "))
        }
        _ => whole.chars().take(SHOWN_WHOLE).chain(['…']).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_values_of_documents_are_summarised() {
        let walls = |n: usize| vec![serde_json::json!({ "from": [0.25, 1.5], "to": [2, 3] }); n];
        let a = serde_json::json!({ "seed": 1, "world": { "walls": walls(24) } });
        let b = serde_json::json!({ "seed": 2, "world": { "walls": walls(26) } });
        let found = ["seed: 1 and 2", "world.walls: a list of 24 and a list of 26"];
        assert_eq!(differences(&a, &b), found);
        let fork = serde_json::json!({ "source": { "forked": { "at": 7, "world": walls(9) } } });
        let whole = serde_json::json!({ "source": "simulated" });
        let found = ["source: \"simulated\" and an object with forked"];
        assert_eq!(differences(&whole, &fork), found);
    }
}
