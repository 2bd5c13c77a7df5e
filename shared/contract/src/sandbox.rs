//! Whether the kernel holds a participant to what it may know.

use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

/// Whether the kernel confines a participant that the server starts: no files,
/// no network, no other process. What exactly, says `rusty_engine::confine`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sandbox {
    /// It runs as any program of this user. In a scenario also `false`.
    #[default]
    None,
    /// Confined as far as this kernel can; the run says what is missing.
    IfPossible,
    /// Confined in full, or there is no run. In a scenario also `true`.
    Required,
}

impl Sandbox {
    /// The word used in files and messages.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::IfPossible => "if-possible",
            Self::Required => "required",
        }
    }

    /// Whether nothing was asked for.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::None
    }
}

impl std::fmt::Display for Sandbox {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.word())
    }
}

impl std::str::FromStr for Sandbox {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        [Self::None, Self::IfPossible, Self::Required]
            .into_iter()
            .find(|sandbox| sandbox.word() == text)
            .ok_or_else(|| format!("{text:?} is no sandbox; use none, if-possible or required"))
    }
}

impl<'de> Deserialize<'de> for Sandbox {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(WordOrFlag)
    }
}

struct WordOrFlag;

impl Visitor<'_> for WordOrFlag {
    type Value = Sandbox;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("\"none\", \"if-possible\", \"required\", true or false")
    }

    fn visit_bool<E: Error>(self, wanted: bool) -> Result<Sandbox, E> {
        Ok(if wanted { Sandbox::Required } else { Sandbox::None })
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<Sandbox, E> {
        word.parse().map_err(E::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sandbox_is_a_word_or_a_flag() {
        let read = |text: &str| serde_json::from_str::<Sandbox>(text);
        for sandbox in [Sandbox::None, Sandbox::IfPossible, Sandbox::Required] {
            let text = serde_json::to_string(&sandbox).unwrap();
            assert_eq!(text, format!("\"{sandbox}\""));
            assert_eq!(read(&text).unwrap(), sandbox);
        }
        assert_eq!(read("true").unwrap(), Sandbox::Required);
        assert_eq!(read("false").unwrap(), Sandbox::None);
        assert!(read("\"maybe\"").unwrap_err().to_string().contains("if-possible"));
        assert!(read("3").unwrap_err().to_string().contains("if-possible"));
    }
}
