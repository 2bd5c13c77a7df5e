//! What runs and participants may be called.

use thiserror::Error;

/// Longest name of a run. The transport puts it into socket paths, which the
/// kernel cuts at 108 bytes.
pub const MAX_RUN_NAME: usize = 24;
/// Longest name of a participant.
pub const MAX_PARTICIPANT_NAME: usize = 32;
/// Longest name of a robot: it is the end of the name of a run.
pub const MAX_ROBOT_NAME: usize = 8;

/// The name of a run: 1 to 24 of `a-z A-Z 0-9 - _`, not starting with `-`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct RunName(String);

/// Why a name is none.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "{what} name {name:?} {problem}; use 1 to {max} letters, digits, '-' or '_', \
     starting with a letter or digit"
)]
pub struct NameError {
    what: &'static str,
    name: String,
    problem: &'static str,
    max: usize,
}

impl RunName {
    /// Checks a name.
    ///
    /// # Errors
    /// [`NameError`] says what is wrong with it.
    pub fn new(name: &str) -> Result<Self, NameError> {
        check("run", name, MAX_RUN_NAME)?;
        Ok(Self(name.to_owned()))
    }

    /// The name as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl std::fmt::Display for RunName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::str::FromStr for RunName {
    type Err = NameError;

    fn from_str(text: &str) -> Result<Self, NameError> {
        Self::new(text)
    }
}

/// Checks the name of a participant: 1 to 32 of the same characters.
///
/// # Errors
/// [`NameError`] says what is wrong with it.
pub fn check_participant_name(name: &str) -> Result<(), NameError> {
    check("participant", name, MAX_PARTICIPANT_NAME)
}

/// Checks the name of a robot: 1 to 8 of the same characters.
///
/// # Errors
/// [`NameError`] says what is wrong with it.
pub fn check_robot_name(name: &str) -> Result<(), NameError> {
    check("robot", name, MAX_ROBOT_NAME)
}

impl NameError {
    /// What is wrong with the name.
    #[must_use]
    pub fn problem(&self) -> &'static str {
        self.problem
    }
}

fn check(what: &'static str, name: &str, max: usize) -> Result<(), NameError> {
    let error = |problem| Err(NameError { what, name: name.to_owned(), problem, max });
    let allowed = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    match name.chars().next() {
        None => error("is empty"),
        Some(first) if !first.is_ascii_alphanumeric() => error("starts with another character"),
        _ if !name.chars().all(allowed) => error("has another character in it"),
        _ if name.len() > max => error("is too long"),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_checked_with_a_reason() {
        for good in ["a", "run-1", "A_b", &"x".repeat(24)] {
            assert!(RunName::new(good).is_ok(), "{good}");
        }
        for (bad, why) in [
            ("", "is empty"),
            ("-a", "starts with"),
            ("a/b", "has another"),
            ("../x", "starts with"),
            ("ä", "starts with"),
            (&"x".repeat(25), "is too long"),
        ] {
            let error = RunName::new(bad).unwrap_err().to_string();
            assert!(error.contains(why), "{error}");
        }
        assert!(check_participant_name("dead-reckoning").is_ok());
    }
}
