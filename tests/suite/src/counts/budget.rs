//! What the counts may come to.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

/// A count that is more than this many percent off its budget is another one.
pub const TOLERANCE_PERCENT: u64 = 5;

/// What writes a new budget.
pub const REMEDY: &str = "cargo run --release -p rusty-tests --bin instruction-counts -- --write";

const HEAD: &str = "\
# Instructions of the core's work, as valgrind counts them in the release build.
# CI fails when one grows by more than 5 %. To announce that, or that one became
# smaller, write this file anew and commit it with the change that caused it:
#   cargo run --release -p rusty-tests --bin instruction-counts -- --write
";

/// The file `tests/suite/instructions.toml`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    /// The compiler that the counts were made with: another may need more or
    /// fewer.
    pub compiler: String,
    /// Instructions by piece of work.
    pub counts: BTreeMap<String, u64>,
}

impl Budget {
    /// As the text of the file.
    pub fn to_text(&self) -> String {
        format!("{HEAD}{}", toml::to_string(self).unwrap())
    }
}

/// A piece of work compared with its budget.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// Which.
    pub name: String,
    /// What it may come to; `None` if it has no budget yet.
    pub budget: Option<u64>,
    /// What it came to; `None` if there is no such work any more.
    pub found: Option<u64>,
}

/// What follows for a piece of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// As agreed.
    Within,
    /// More than agreed: fails.
    Grown,
    /// Less than agreed; the budget should follow.
    Shrunk,
    /// Nothing is agreed: fails.
    WithoutBudget,
    /// There is a budget for nothing: fails.
    WithoutWork,
}

impl Line {
    /// What follows.
    pub fn verdict(&self) -> Verdict {
        match (self.budget, self.found) {
            (None, _) => Verdict::WithoutBudget,
            (_, None) => Verdict::WithoutWork,
            // In whole numbers: exactly 5 % is within.
            (Some(budget), Some(found)) if found * 100 > budget * (100 + TOLERANCE_PERCENT) => {
                Verdict::Grown
            }
            (Some(budget), Some(found)) if found * 100 < budget * (100 - TOLERANCE_PERCENT) => {
                Verdict::Shrunk
            }
            (Some(_), Some(_)) => Verdict::Within,
        }
    }

    /// Whether this is a failure.
    pub fn fails(&self) -> bool {
        !matches!(self.verdict(), Verdict::Within | Verdict::Shrunk)
    }
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (budget, found) = (self.budget.unwrap_or(0), self.found.unwrap_or(0));
        write!(f, "{:21} {found:>12} of {budget:>12}  ", self.name)?;
        let percent = 100.0 * (found as f64 / budget as f64 - 1.0);
        match self.verdict() {
            Verdict::Within => write!(f, "{percent:+.2} %"),
            Verdict::Grown => write!(f, "{percent:+.2} %  TOO MANY"),
            Verdict::Shrunk => write!(f, "{percent:+.2} %  fewer: lower the budget"),
            Verdict::WithoutBudget => write!(f, "NO BUDGET"),
            Verdict::WithoutWork => write!(f, "NO SUCH WORK"),
        }
    }
}

/// Every piece of work that is counted or has a budget.
pub fn compare(budget: &Budget, found: &BTreeMap<String, u64>) -> Vec<Line> {
    let mut names: Vec<&String> = budget.counts.keys().chain(found.keys()).collect();
    names.sort();
    names.dedup();
    let line = |name: &String| Line {
        name: name.clone(),
        budget: budget.counts.get(name).copied(),
        found: found.get(name).copied(),
    };
    names.into_iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(counts: &[(&str, u64)]) -> BTreeMap<String, u64> {
        counts.iter().map(|(name, count)| ((*name).to_owned(), *count)).collect()
    }

    fn verdict(budget: u64, found: u64) -> (Verdict, bool) {
        let budget = Budget { compiler: String::new(), counts: counts(&[("step", budget)]) };
        let lines = compare(&budget, &counts(&[("step", found)]));
        (lines[0].verdict(), lines[0].fails())
    }

    #[test]
    fn six_percent_more_fails_and_says_by_how_much() {
        assert_eq!(verdict(1000, 1060), (Verdict::Grown, true));
        assert_eq!(verdict(1000, 1051), (Verdict::Grown, true));
        assert_eq!(verdict(1000, 1050), (Verdict::Within, false));
        let line = Line { name: "step".to_owned(), budget: Some(1000), found: Some(1060) };
        assert!(line.to_string().contains("+6.00 %  TOO MANY"), "{line}");
    }

    #[test]
    fn six_percent_less_asks_for_a_lower_budget() {
        assert_eq!(verdict(1000, 940), (Verdict::Shrunk, false));
        assert_eq!(verdict(1000, 950), (Verdict::Within, false));
    }

    #[test]
    fn work_and_budget_need_each_other() {
        let budget = Budget { compiler: String::new(), counts: counts(&[("a", 1), ("b", 1)]) };
        let lines = compare(&budget, &counts(&[("b", 1), ("c", 1)]));
        let verdicts: Vec<Verdict> = lines.iter().map(Line::verdict).collect();
        assert_eq!(verdicts, [Verdict::WithoutWork, Verdict::Within, Verdict::WithoutBudget]);
        assert!(lines[0].fails() && lines[2].fails());
    }

    #[test]
    fn the_file_reads_back() {
        let budget = Budget { compiler: "rustc 1".to_owned(), counts: counts(&[("a", 1)]) };
        assert_eq!(toml::from_str::<Budget>(&budget.to_text()).unwrap(), budget);
    }
}
