//! `Entry`: a program that takes part.

use rusty_contract::scenario::Access;
use rusty_contract::{FieldError, Participant, Role, Sandbox};
use rusty_engine::scenario_file::add_estimator;
use serde::{Deserialize, Serialize};

use super::suite::{Suite, SuiteScenario};
use super::track::Track;

/// What stands for the name of the run in a command: see [`run_name`](super::block::run_name).
pub const RUN: &str = "{run}";

/// A program that takes part.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Entry {
    /// Its name.
    pub name: String,
    /// Program and arguments.
    pub command: Vec<String>,
    /// Whether it is one of the suite's.
    pub is_baseline: bool,
    /// Whether it drives; the others are estimators.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_driver: bool,
    /// Files that it may read.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
}

impl Entry {
    /// Reads the entries of `--add NAME=COMMAND` and `--driver NAME=COMMAND`, which may read
    /// `files`.
    ///
    /// # Errors
    /// [`FieldError`] names option, value and remedy.
    pub fn added(
        suite: &Suite,
        [add, drivers]: [&[String]; 2],
        files: &[String],
    ) -> Result<Vec<Self>, FieldError> {
        let mut roster = Vec::new();
        let all = add.iter().map(|text| (text, false));
        for (text, is_driver) in all.chain(drivers.iter().map(|text| (text, true))) {
            let option = option(is_driver);
            let wrong =
                |problem: &str, remedy: &str| Err(FieldError::new(option, text, problem, remedy));
            let mut own = Vec::new();
            add_estimator(&mut own, option, text)?;
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
            let files = files.to_vec();
            roster.push(Self { name, command, is_baseline: false, is_driver, files });
        }
        Ok(roster)
    }

    /// Returns whether it takes part in a track of a scenario.
    #[must_use]
    pub fn takes_part(&self, suite: &Suite, scenario: &SuiteScenario, track: Track) -> bool {
        let mut baselines = suite.baselines_of(scenario, track);
        self.is_driver == track.is_driving()
            && (!self.is_baseline || baselines.any(|baseline| baseline.name == self.name))
    }

    /// Returns the option that adds it.
    #[must_use]
    pub fn option(&self) -> &'static str {
        option(self.is_driver)
    }

    /// Returns the baselines.
    #[must_use]
    pub fn baselines(suite: &Suite) -> Vec<Self> {
        let entry = |b: &super::suite::Baseline| Self {
            name: b.name.clone(),
            command: b.command.clone(),
            is_baseline: true,
            is_driver: b.tracks.contains(&Track::Driving),
            files: Vec::new(),
        };
        suite.baselines.iter().map(entry).collect()
    }

    /// Returns whether its command has the name of the run in it, as [`RUN`].
    #[must_use]
    pub fn differs_by_run(&self) -> bool {
        self.command.iter().any(|word| word.contains(RUN))
    }

    /// Returns whether its command has [`RUN`].
    #[must_use]
    pub fn is_by_run(&self) -> bool {
        self.command.iter().any(|word| word.contains(RUN))
    }

    /// Returns it with the name of a run in place of [`RUN`].
    #[must_use]
    pub fn of_run(&self, run: &str) -> Self {
        let command = self.command.iter().map(|word| word.replace(RUN, run)).collect();
        Self { command, ..self.clone() }
    }

    /// Returns it as a participant that receives this much.
    #[must_use]
    pub fn participant(&self, initial_pose: Access, map: Access, sandbox: Sandbox) -> Participant {
        let role = if self.is_driver { Role::Driver } else { Role::Estimator };
        let own = started(&self.name, role, &self.command);
        Participant { map, initial_pose, sandbox, files: self.files.clone(), ..own }
    }

    /// Returns the roster of its runs: with the driver of the scenario, if there is one and
    /// the entry does not drive, and the scorer. A driver has the goals as `--waypoint X,Y`.
    #[must_use]
    pub fn roster(
        &self,
        scenario: &SuiteScenario,
        map: Access,
        sandbox: Sandbox,
    ) -> Vec<Participant> {
        let mut own = self.participant(scenario.start, map, sandbox);
        let mut score = vec!["score".to_owned()];
        if self.is_driver {
            own.command.extend(scenario.goals_after("--waypoint"));
            score.extend(scenario.goals_after("--goal"));
        }
        let mut roster = vec![own, started("score", Role::Scorer, &score)];
        if !self.is_driver && !scenario.driver.is_empty() {
            roster.insert(0, started("driver", Role::Driver, &scenario.driver));
        }
        roster
    }
}

/// A participant that this program starts.
pub(super) fn started(name: &str, role: Role, command: &[String]) -> Participant {
    Participant { command: command.to_vec(), ..Participant::new(name, role) }
}

fn option(is_driver: bool) -> &'static str {
    if is_driver { "--driver" } else { "--add" }
}
