//! The text of a cell, with the figures of a command and the digits of the page.

use serde_json::Value;

/// Verdicts about covariances.
const VERDICTS: [&str; 3] = ["consistent", "conservative", "overconfident"];

/// The longest time to the first answer of an estimator that gets the pose.
const AT_ONCE_WITHIN_S: f64 = 0.1;

/// Returns the cell as the figures have it. `cell` is the page's text, whose digits and
/// words are kept.
pub fn corrected(cell: &str, fields: &[&str], figures: &Value) -> String {
    let value = |field: &str| figures.pointer(&format!("/{field}")).unwrap_or(&Value::Null);
    if value(fields[0]).is_null() {
        return "–".to_owned();
    }
    if fields.contains(&"found") && value("found") == 0 {
        return "abstains".to_owned();
    }
    let all_found = value("found") == value("runs");
    let last_found_s = value("found_after_p95_s").as_f64().unwrap_or(f64::NAN);
    if fields.contains(&"found_after_s") && all_found && last_found_s <= AT_ONCE_WITHIN_S {
        return "at once".to_owned();
    }
    let (mut numbers, mut text) = (Vec::new(), cell.to_owned());
    for field in fields {
        match value(field) {
            Value::String(verdict) => {
                let old = VERDICTS.iter().find(|old| cell.contains(*old));
                text = old.map_or(text.clone(), |old| text.replace(old, verdict));
            }
            // A replay is a single run, of which there is no range.
            Value::Null if field.contains("_range_") => {}
            number => {
                let factor = if field.ends_with("_rad") { 1f64.to_degrees() } else { 1.0 };
                numbers.push(number.as_f64().unwrap_or(f64::NAN) * factor);
            }
        }
    }
    with_numbers(&text, &numbers)
}

/// Returns the text with other numbers, each with as many decimals as the number that it
/// replaces; the numbers alone where the text has a different count.
pub fn with_numbers(text: &str, numbers: &[f64]) -> String {
    let is_number = |byte: &u8| byte.is_ascii_digit() || *byte == b'.';
    let parts = text.as_bytes().chunk_by(|a, b| is_number(a) == is_number(b));
    let mut left = numbers.iter();
    let parts = parts.map(|part| match str::from_utf8(part).unwrap() {
        number if number.starts_with(|c: char| c.is_ascii_digit()) => {
            let decimals = number.split_once('.').map_or(0, |(_, decimals)| decimals.len());
            left.next().map(|value| format!("{value:.decimals$}"))
        }
        words => Some(words.to_owned()),
    });
    let replaced = parts.collect::<Option<String>>();
    let is_complete = left.next().is_none();
    replaced.filter(|_| is_complete).unwrap_or_else(|| format!("{numbers:?}"))
}

#[test]
fn a_cell_keeps_its_digits_and_words() {
    let figures = serde_json::json!({
        "rmse_m": 0.001_26, "rmse_rad": 0.01, "anees": 2.316, "verdict": "consistent",
        "found": 5, "runs": 5, "found_after_s": 0.424, "found_after_p95_s": 0.5, "nis": null,
        "rmse_range_m": [0.001, 0.0042], "other_range_m": null,
    });
    let of = |cell, fields: &[&str]| corrected(cell, fields, &figures);
    assert_eq!(of("0.002 m, 1.0 °", &["rmse_m", "rmse_rad"]), "0.001 m, 0.6 °");
    assert_eq!(of("2.29 overconfident", &["anees", "verdict"]), "2.32 consistent");
    assert_eq!(of("2 of 3, 1.0 s", &["found", "runs", "found_after_s"]), "5 of 5, 0.4 s");
    let range = ["rmse_m", "rmse_range_m/0", "rmse_range_m/1"];
    assert_eq!(of("0.002 (0.0030–0.04) m", &range), "0.001 (0.0010–0.00) m");
    assert_eq!(of("0.002 m", &["rmse_m", "other_range_m/0"]), "0.001 m");
    assert_eq!(of("0.002 m", &["rmse_m", "nis"]), "[0.00126, NaN]");
    assert_eq!(of("1.1", &["nis"]), "–");
    assert_eq!(of("–", &["anees", "verdict"]), "[2.316]");
}
