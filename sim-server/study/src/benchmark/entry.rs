//! `Entry`: a program that takes part.

use rusty_contract::scenario::Access;
use rusty_contract::{FieldError, Participant, Role, Sandbox};
use rusty_engine::scenario_file::add_estimator;
use serde::{Deserialize, Serialize};

use super::suite::{Suite, SuiteScenario};

/// A program that takes part.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Entry {
    /// Its name.
    pub name: String,
    /// Program and arguments.
    pub command: Vec<String>,
    /// Whether it is one of the suite's.
    pub is_baseline: bool,
    /// Files that it may read.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
}

impl Entry {
    /// Reads the entries of `--add NAME=COMMAND`, which may read `files`.
    ///
    /// # Errors
    /// [`FieldError`] names option, value and remedy.
    pub fn added(suite: &Suite, add: &[String], files: &[String]) -> Result<Vec<Self>, FieldError> {
        let mut roster = Vec::new();
        for text in add {
            let wrong =
                |problem: &str, remedy: &str| Err(FieldError::new("--add", text, problem, remedy));
            let mut own = Vec::new();
            add_estimator(&mut own, text);
            let Some(Participant { name, command, .. }) = own.pop() else { continue };
            if command.is_empty() {
                return wrong("has no command", "write NAME=COMMAND: mine=./target/release/mine");
            }
            let taken = |known: &str| known == name;
            if ["driver", "score"].iter().any(|known| taken(known))
                || suite.baselines.iter().any(|b| taken(&b.name))
                || roster.iter().any(|entry: &Self| taken(&entry.name))
            {
                return wrong("has a name that is in use", "choose another name");
            }
            roster.push(Self { name, command, is_baseline: false, files: files.to_vec() });
        }
        Ok(roster)
    }

    /// Returns the baselines.
    #[must_use]
    pub fn baselines(suite: &Suite) -> Vec<Self> {
        let entry = |b: &super::suite::Baseline| Self {
            name: b.name.clone(),
            command: b.command.clone(),
            is_baseline: true,
            files: Vec::new(),
        };
        suite.baselines.iter().map(entry).collect()
    }

    /// Returns the roster of its runs: with the driver of the scenario, if there is one, and
    /// the scorer.
    #[must_use]
    pub fn roster(
        &self,
        scenario: &SuiteScenario,
        map: Access,
        sandbox: Sandbox,
    ) -> Vec<Participant> {
        let started = |name: &str, role, command: &[String]| Participant {
            command: command.to_vec(),
            ..Participant::new(name, role)
        };
        let estimator = Participant {
            map,
            initial_pose: scenario.start,
            sandbox,
            files: self.files.clone(),
            ..started(&self.name, Role::Estimator, &self.command)
        };
        let mut roster = vec![estimator, Participant::new("score", Role::Scorer)];
        if !scenario.driver.is_empty() {
            roster.insert(0, started("driver", Role::Driver, &scenario.driver));
        }
        roster
    }
}
