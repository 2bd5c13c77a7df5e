//! The file a person writes: a run, and who takes part with which rights.

mod participant;
mod robots;
mod seed;

use std::collections::BTreeSet;

use rusty_geometry::{SE2, WorldSpec};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::config::{
    CrowdConfig, Event, PatchConfig, Sensors, WalkerConfig, at_least, check_times_and_start,
    seconds,
};
use crate::config::{
    FieldError, Fleet, Kidnapping, LidarConfig, OtherRobot, RunConfig, ScriptConfig,
};
use crate::json::json_tree;
use crate::names::{NameError, check_participant_name};
use crate::suggest::{did_you_mean, for_message, without_types};
use crate::tally::MAX_PARTICIPANTS;

pub use self::participant::{Access, Participant, Role};
pub use self::robots::{RobotEntry, Robots, RobotsOwn, has_null};

/// A scenario file (TOML). Every field has a default; an empty file is the
/// Apartment patrol with dead reckoning, scorer and logger.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scenario {
    /// What to call it.
    pub name: String,
    /// The seed of all noise.
    #[serde(with = "seed")]
    pub seed: u64,
    /// How many ticks.
    pub ticks: u64,
    /// Length of a tick, s.
    pub dt_s: f64,
    /// One scan every N ticks; 0: none.
    pub scan_every: u64,
    /// A built-in place, such as `apartment`.
    pub world: String,
    /// A world file instead (a floor plan, a map of ROS or a drawing), relative to the
    /// scenario's folder.
    pub world_file: Option<String>,
    /// Where the robot starts, world frame.
    pub start: SE2,
    /// What happens when a required participant is lost.
    pub on_loss: OnLoss,
    /// How long a participant may take for an answer, s.
    pub answer_timeout_s: f64,
    /// How long the server waits for all to join, s.
    pub join_timeout_s: f64,
    /// The robot, or the robots.
    pub robot: Robots,
    /// The LiDAR.
    pub lidar: LidarConfig,
    /// The small sensors.
    #[serde(skip_serializing_if = "Sensors::is_none")]
    pub sensors: Sensors,
    /// Where the commands come from.
    pub script: ScriptConfig,
    /// Where the robot is carried away, in the order of the ticks.
    #[serde(rename = "kidnapping", skip_serializing_if = "Vec::is_empty")]
    pub kidnappings: Vec<Kidnapping>,
    /// People who walk along waypoints.
    #[serde(rename = "walker", skip_serializing_if = "Vec::is_empty")]
    pub walkers: Vec<WalkerConfig>,
    /// People who walk by social forces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crowd: Option<CrowdConfig>,
    /// What changes in the world, in the order of the ticks.
    #[serde(rename = "event", skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<Event>,
    /// Where on the floor the wheels slip otherwise.
    #[serde(rename = "patch", skip_serializing_if = "Vec::is_empty")]
    pub patches: Vec<PatchConfig>,
    /// Who takes part, in roster order.
    #[serde(rename = "participant")]
    pub participants: Vec<Participant>,
}

/// What happens when a required participant is lost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OnLoss {
    /// The run ends, and says who was lost.
    #[default]
    Abort,
    /// The run goes on without it; its answers count as missing.
    Continue,
    /// The run waits until it is back: its program is started again, is given
    /// all ticks from the first on, and answers them again. One that is
    /// deterministic cannot tell that it was away, and neither can the digest.
    Restart,
}

impl Default for Scenario {
    fn default() -> Self {
        Self {
            name: "apartment".to_owned(),
            seed: 42,
            ticks: 1500,
            dt_s: 0.02,
            scan_every: 5,
            world: "apartment".to_owned(),
            world_file: None,
            start: SE2::new(6.0, 4.5, 0.0),
            on_loss: OnLoss::Abort,
            answer_timeout_s: 10.0,
            join_timeout_s: 20.0,
            robot: Robots::default(),
            lidar: LidarConfig::default(),
            sensors: Sensors::default(),
            script: ScriptConfig::default(),
            kidnappings: Vec::new(),
            walkers: Vec::new(),
            crowd: None,
            events: Vec::new(),
            patches: Vec::new(),
            participants: Self::usual_participants(),
        }
    }
}

/// Why a scenario cannot be run.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ScenarioError {
    /// The text is no scenario: the parser's words, with line and field.
    #[error("{0}")]
    Syntax(String),
    /// A field cannot be used.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A participant's name cannot be used.
    #[error("participant: {0}")]
    Name(#[from] NameError),
}

json_tree!(Scenario);

impl Scenario {
    /// Dead reckoning, scorer and logger.
    #[must_use]
    pub fn usual_participants() -> Vec<Participant> {
        vec![
            Participant::new("dead-reckoning", Role::Estimator),
            Participant::new("score", Role::Scorer),
            Participant::new("logger", Role::Logger),
        ]
    }

    /// Reads and checks a scenario.
    ///
    /// # Errors
    /// [`ScenarioError`] with line, field, value and remedy.
    pub fn from_toml(text: &str) -> Result<Self, ScenarioError> {
        let scenario: Self = toml::from_str(text).map_err(|e| syntax_error(text, &e))?;
        scenario.check()?;
        Ok(scenario)
    }

    /// Returns the configuration of the run in a world: of the first robot's, where there
    /// are several. A script's file is not read.
    #[must_use]
    pub fn config(&self, world: WorldSpec) -> RunConfig {
        self.config_of(0, world)
    }

    /// Returns the configuration of the run of one robot of several; 0 is the only place
    /// where there is one.
    #[must_use]
    pub fn config_of(&self, place: usize, world: WorldSpec) -> RunConfig {
        let config = RunConfig {
            scenario: self.name.clone(),
            seed: self.seed,
            ticks: self.ticks,
            dt_s: self.dt_s,
            scan_every: self.scan_every,
            start: self.start,
            robot: *self.robot,
            lidar: self.lidar,
            sensors: self.sensors.clone(),
            script: self.script.clone(),
            world,
            kidnappings: self.kidnappings.clone(),
            walkers: self.walkers.clone(),
            crowd: self.crowd,
            events: self.events.clone(),
            patches: self.patches.clone(),
            fleet: None,
        };
        let Some(entry) = self.robot.entries().get(place) else { return config };
        let OtherRobot { name, start, robot, script, kidnappings } = self.other(entry);
        let others = self.robot.entries().iter().enumerate();
        let others = others.filter(|(i, _)| *i != place).map(|(_, entry)| self.other(entry));
        let fleet = Some(Box::new(Fleet { name, place, others: others.collect() }));
        let sensors = entry.own.sensors.clone().unwrap_or(config.sensors);
        let lidar = entry.own.lidar.unwrap_or(self.lidar);
        RunConfig { start, robot, script, kidnappings, lidar, sensors, fleet, ..config }
    }

    /// How one robot of several moves.
    fn other(&self, entry: &RobotEntry) -> OtherRobot {
        let RobotsOwn { start, script, kidnappings, .. } = entry.own.clone();
        OtherRobot {
            name: entry.name.clone(),
            start: start.unwrap_or(self.start),
            robot: entry.robot,
            script: script.unwrap_or_else(|| self.script.clone()),
            kidnappings,
        }
    }

    /// Who takes part for one robot of several, in roster order; all where there is one.
    #[must_use]
    pub fn roster_of(&self, place: usize) -> Vec<Participant> {
        let robot = self.robot.entries().get(place).map(|entry| entry.name.as_str());
        self.participants.iter().filter(|p| p.takes_part_for(robot)).cloned().collect()
    }

    /// Checks every field but the files it names.
    ///
    /// # Errors
    /// [`ScenarioError`] names the first that cannot be used.
    pub fn check(&self) -> Result<(), ScenarioError> {
        at_least("ticks", self.ticks, 1, 1 << 40)?;
        check_times_and_start(self.dt_s, self.scan_every, self.start)?;
        seconds("answer_timeout_s", self.answer_timeout_s)?;
        seconds("join_timeout_s", self.join_timeout_s)?;
        self.robot.check()?;
        self.lidar.check()?;
        self.sensors.check()?;
        self.script.check()?;
        Kidnapping::check(&self.kidnappings)?;
        WalkerConfig::check(&self.walkers)?;
        self.crowd.as_ref().map_or(Ok(()), CrowdConfig::check)?;
        Event::check(&self.events)?;
        PatchConfig::check(&self.patches)?;
        self.check_participants()
    }

    /// Checks names, number and rights of participants, but for the driver.
    ///
    /// # Errors
    /// [`ScenarioError`] names the first that cannot be used.
    pub fn check_roster(participants: &[Participant]) -> Result<(), ScenarioError> {
        let count = participants.len();
        at_least("participant (number of)", count as u64, 0, MAX_PARTICIPANTS as u64)?;
        let mut names = BTreeSet::new();
        for (i, p) in participants.iter().enumerate() {
            check_participant_name(&p.name)?;
            if !p.required && !matches!(p.role, Role::Estimator | Role::Observer) {
                // It could miss frames: the score or log would have gaps, the
                // robot would stand.
                let field = format!("participant[{i}].required");
                let problem = format!("cannot be false for a {}", p.role);
                let remedy = "leave it out, or choose the role observer";
                return Err(FieldError::new(field, "false", problem, remedy).into());
            }
            if p.role.holds_key() && !p.sandbox.is_none() {
                let field = format!("participant[{i}].sandbox");
                let problem = format!("cannot be had by a {}: it is told the truth", p.role);
                let remedy = "leave it out: the sandbox is for those who answer or look on";
                return Err(FieldError::new(field, p.sandbox, problem, remedy).into());
            }
            p.compute.check(&format!("participant[{i}].compute"))?;
            if !p.answers() && !p.compute.is_none() {
                let field = format!("participant[{i}].compute");
                let problem = "can be modelled only where answers are part of the run";
                let remedy = "leave it out, or give it to an estimator or driver";
                return Err(FieldError::new(field, p.role, problem, remedy).into());
            }
            if !names.insert(&p.name) {
                let field = format!("participant[{i}].name");
                let remedy = "give every participant a name of its own";
                return Err(FieldError::new(field, &p.name, "is there twice", remedy).into());
            }
        }
        Ok(())
    }

    fn check_participants(&self) -> Result<(), ScenarioError> {
        let entries = self.robot.entries();
        for (i, p) in self.participants.iter().enumerate() {
            let Some(robot) = &p.robot else { continue };
            if entries.iter().all(|entry| entry.name != *robot) {
                let names = entries.iter().map(|entry| entry.name.as_str());
                let hint = did_you_mean(robot, names.clone());
                let names: Vec<&str> = names.collect();
                let remedy = match names.is_empty() {
                    true => {
                        "leave it out: the scenario has one robot, which needs no name".to_owned()
                    }
                    false => format!("use one of: {}{hint}", names.join(", ")),
                };
                let field = format!("participant[{i}].robot");
                return Err(FieldError::new(field, robot, "is no robot", remedy).into());
            }
        }
        for place in 0..entries.len().max(1) {
            let roster = self.roster_of(place);
            Self::check_roster(&roster)?;
            let script = entries.get(place).and_then(|entry| entry.own.script.as_ref());
            check_drivers(&roster, script.unwrap_or(&self.script), entries.get(place))?;
        }
        // Names, starts and scripts of several, with what the scenario lends them.
        if !entries.is_empty() {
            if !self.kidnappings.is_empty() {
                let problem = "does not say which robot is carried away";
                let remedy = "write [[robot.kidnapping]] behind the robot's [[robot]]";
                let tick = self.kidnappings[0].tick;
                return Err(FieldError::new("kidnapping[0].tick", tick, problem, remedy).into());
            }
            let nowhere = WorldSpec {
                name: "none".to_owned(),
                bounds: [-1e6, -1e6, 1e6, 1e6],
                walls: Vec::new(),
                landmarks: Vec::new(),
            };
            self.config(nowhere).check_fleet()?;
        }
        Ok(())
    }
}

/// Checks that a robot has a driver if, and only if, its script is that of one.
fn check_drivers(
    roster: &[Participant],
    script: &ScriptConfig,
    robot: Option<&RobotEntry>,
) -> Result<(), FieldError> {
    let drivers = roster.iter().filter(|p| p.role == Role::Driver).count();
    let wanted = usize::from(script.is_driver());
    if drivers == wanted {
        return Ok(());
    }
    let (problem, remedy) = if wanted == 1 {
        ("must be 1 with script kind \"driver\"", "give one participant role = \"driver\"")
    } else {
        ("must be 0 with this script", "set [script] kind = \"driver\", or another role")
    };
    let field = robot.map_or("drivers".to_owned(), |robot| format!("drivers of {}", robot.name));
    Err(FieldError::new(field, drivers, problem, remedy))
}

/// Returns the parser's error about a scenario's text, with a suggestion. A table
/// (`[participant]`) where a list of tables (`[[participant]]`) belongs is named.
fn syntax_error(text: &str, error: &toml::de::Error) -> ScenarioError {
    let table: toml::Table = toml::from_str(text).unwrap_or_default();
    let is_table = |key: &&str| table.get(*key).is_some_and(toml::Value::is_table);
    if let Some(list) = ["kidnapping", "participant", "patch"].into_iter().find(is_table) {
        let remedy = format!("write [[{list}]], once for each");
        let value = format!("[{list}]");
        return FieldError::new(list, value, "is a table, expected a list", remedy).into();
    }
    let hint = for_message(error.message());
    ScenarioError::Syntax(format!("{}{hint}", without_types(error.to_string().trim_end())))
}

#[cfg(test)]
mod tests;
