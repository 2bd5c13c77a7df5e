//! What a check found.

/// What a check came to, and what was seen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The client keeps the rule, as far as the check can see.
    Pass(String),
    /// It does not.
    Fail(String),
    /// The check says nothing about this client, and why.
    NotApplicable(String),
}
