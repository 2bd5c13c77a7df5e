//! Suggestions for misspelled names: "did you mean".

/// The least similarity (Jaro-Winkler) of a suggestion.
const SIMILAR: f64 = 0.8;
/// Longer words are not compared: the cost grows with the square of the length.
const MAX_WORD_BYTES: usize = 64;

/// Returns the candidate that is most similar to `word`, if one is similar enough.
#[must_use]
pub fn closest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if word.len() > MAX_WORD_BYTES {
        return None;
    }
    let scored = candidates.into_iter().map(|c| (strsim::jaro_winkler(word, c), c));
    let similar = scored.filter(|(similarity, _)| *similarity >= SIMILAR);
    similar.max_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, candidate)| candidate)
}

/// Returns the end of an error message: `; did you mean "beams"?`, or nothing.
#[must_use]
pub fn did_you_mean<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    closest(word, candidates).map(|c| format!("; did you mean {c:?}?")).unwrap_or_default()
}

/// The same for a parser's message that lists the names it knows:
/// ``unknown field `beems`, expected one of `beams`, …``.
#[must_use]
pub fn for_message(message: &str) -> String {
    let Some((_, names)) = message.rsplit_once("unknown ") else { return String::new() };
    let mut quoted = names.split('`').skip(1).step_by(2);
    quoted.next().map(|word| did_you_mean(word, quoted)).unwrap_or_default()
}

/// A parser's message without the names of types, which are tables in a file.
#[must_use]
pub fn without_types(message: &str) -> String {
    let types = ["struct", "internally tagged enum", "untagged enum", "enum"];
    let cut = |kind| message.split_once(&format!("expected {kind} "));
    let Some((before, name)) = types.into_iter().find_map(cut) else { return message.to_owned() };
    format!("{before}expected a table{}", name.trim_start_matches(char::is_alphanumeric))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closest_name_is_found_and_a_strange_one_is_not() {
        let names = ["apartment", "patrol", "figure-eight", "hallway", "driver"];
        for (word, expected) in [
            ("apartmnt", Some("apartment")),
            ("figure_eight", Some("figure-eight")),
            ("halway", Some("hallway")),
            ("moon", None),
            ("", None),
        ] {
            assert_eq!(closest(word, names), expected, "{word}");
        }
        assert_eq!(closest(&"apartment".repeat(100_000), names), None);
        assert_eq!(closest("x", []), None);
    }

    #[test]
    fn a_message_that_lists_names_gets_a_suggestion() {
        let listed = "unknown field `beems`, expected one of `beams`, `fov_rad`";
        assert_eq!(for_message(listed), "; did you mean \"beams\"?");
        assert_eq!(for_message("unknown variant `waltz`, expected `patrol` or `driver`"), "");
        assert_eq!(for_message("unknown"), "");
        assert_eq!(for_message("invalid type: string \"a\", expected f64"), "");
    }

    #[test]
    fn a_message_names_no_type() {
        for (message, plain) in [
            (
                "invalid type: string \"a\", expected struct WorldSpec",
                "string \"a\", expected a table",
            ),
            ("integer `3`, expected internally tagged enum Script at line 2", "a table at line 2"),
            ("invalid type: string \"a\", expected f64", "string \"a\", expected f64"),
        ] {
            assert!(without_types(message).ends_with(plain), "{}", without_types(message));
        }
    }
}
