//! Commands in words, as a shell reads and writes them.

use std::borrow::Cow;

use rusty_contract::FieldError;

/// Splits the command of an option, such as `--add`, into words. Quotes and backslashes keep
/// spaces in a word; nothing is expanded.
///
/// # Errors
/// [`FieldError`] where a quote has no end.
pub fn words(option: &str, command: &str) -> Result<Vec<String>, FieldError> {
    shlex::split(command).ok_or_else(|| {
        let remedy = "close it, or put a backslash before one that belongs to a word";
        FieldError::new(option, command, "has a quote without an end", remedy)
    })
}

/// A word as it has to be written in a command that is printed.
#[must_use]
pub fn quoted(word: &str) -> Cow<'_, str> {
    // No word of a command has a NUL.
    shlex::try_quote(word).unwrap_or(Cow::Borrowed(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_keep_spaces_in_a_word() {
        let words = words("--add", r#"mcl --map 'my maps/a.yaml' "b c" d\ e {run}.tum"#).unwrap();
        assert_eq!(words, ["mcl", "--map", "my maps/a.yaml", "b c", "d e", "{run}.tum"]);
        assert!(super::words("--add", "  ").unwrap().is_empty());
    }

    #[test]
    fn a_quote_without_an_end_is_refused_with_the_option() {
        for command in ["mcl 'a", "mcl \"a", "mcl a\\"] {
            let error = words("--driver", command).unwrap_err();
            assert_eq!((error.field.as_str(), error.value.as_str()), ("--driver", command));
        }
    }

    #[test]
    fn what_is_quoted_is_one_word_again() {
        for word in ["plain.log", "my run.log", "it's \"odd\" \\ $HOME", ""] {
            assert_eq!(words("--add", &quoted(word)).unwrap(), [word], "{word}");
        }
        assert_eq!(quoted("runs/a-1.log"), "runs/a-1.log");
    }
}
