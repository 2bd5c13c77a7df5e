//! The results of the checks, as a table and as JSON.

use rusty_contract::{Exit, Role};
use serde::Serialize;

use super::Kit;
use super::catalogue::Check;
use super::verdict::Verdict;

/// The result of a check.
#[derive(Serialize)]
pub struct Finding {
    /// The check.
    #[serde(flatten)]
    pub check: &'static Check,
    /// `pass`, `fail` or `not applicable`.
    pub verdict: &'static str,
    /// What was seen.
    pub seen: String,
}

/// All of it.
#[derive(Serialize)]
pub struct Report {
    /// Program and arguments.
    pub client: Vec<String>,
    /// What it was tested as.
    pub role: Role,
    /// The longest wait for anything, s.
    pub patience_s: f64,
    /// How many checks passed.
    pub passed: usize,
    /// How many failed.
    pub failed: usize,
    /// How many say nothing about this client.
    pub not_applicable: usize,
    /// Checks that were not made, because the kit was asked to stop.
    pub not_made: usize,
    /// Check by check.
    pub checks: Vec<Finding>,
}

impl Finding {
    pub(super) fn new(check: &'static Check, verdict: Verdict) -> Self {
        let (verdict, seen) = match verdict {
            Verdict::Pass(seen) => ("pass", seen),
            Verdict::Fail(seen) => ("fail", seen),
            Verdict::NotApplicable(why) => ("not applicable", why),
        };
        Self { check, verdict, seen }
    }
}

impl Report {
    /// The report on these findings, of `wanted` checks.
    #[must_use]
    pub fn new(kit: &Kit, wanted: usize, checks: Vec<Finding>) -> Self {
        let count = |word| checks.iter().filter(|f| f.verdict == word).count();
        Self {
            client: kit.command.clone(),
            role: kit.role,
            patience_s: kit.patience.as_secs_f64(),
            passed: count("pass"),
            failed: count("fail"),
            not_applicable: count("not applicable"),
            not_made: wanted - checks.len(),
            checks,
        }
    }

    /// The exit code that goes with it.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match (self.failed, self.not_made) {
            (0, 0) => Exit::Done,
            (0, _) => Exit::Lost,
            _ => Exit::Failed,
        }
    }
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for Finding { check, verdict, seen } in &self.checks {
            let Check { name, done, expected, .. } = check;
            let verdict = if *verdict == "not applicable" { "n/a" } else { verdict };
            writeln!(f, "{verdict:4}  {name:24}  {done}; expected {expected}; seen: {seen}")?;
        }
        for Finding { check, seen, .. } in self.checks.iter().filter(|c| c.verdict == "fail") {
            writeln!(f, "\n{check}\n  seen      {seen}")?;
        }
        let Self { role, passed, failed, not_applicable, not_made, .. } = self;
        write!(
            f,
            "\nas {role}: {passed} passed, {failed} failed, {not_applicable} not applicable"
        )?;
        if *not_made > 0 {
            write!(f, ", {not_made} not made: stopped on request")?;
        }
        Ok(())
    }
}
