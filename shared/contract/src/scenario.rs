//! The file a person writes: a run, and who takes part with which rights.

use std::collections::BTreeSet;

use rusty_geometry::{SE2, WorldSpec};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::config::{
    CrowdConfig, Event, PatchConfig, Sensors, WalkerConfig, at_least, check_times_and_start,
    seconds,
};
use crate::config::{FieldError, Kidnapping, LidarConfig, RobotConfig, RunConfig, ScriptConfig};
use crate::names::{NameError, check_participant_name};
use crate::sandbox::Sandbox;
use crate::suggest::for_message;
use crate::tally::MAX_PARTICIPANTS;
use crate::timing::ComputeTime;

/// A scenario file (TOML). Every field has a default; an empty file is the
/// Apartment patrol with dead reckoning, scorer and logger.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scenario {
    /// What to call it.
    pub name: String,
    /// The seed of all noise.
    pub seed: u64,
    /// How many ticks.
    pub ticks: u64,
    /// Length of a tick, s.
    pub dt_s: f64,
    /// One scan every N ticks; 0: none.
    pub scan_every: u64,
    /// A built-in place: `open`, `hallway`, `apartment`.
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
    /// The robot.
    pub robot: RobotConfig,
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

/// What a participant may know and do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Answers with estimates.
    Estimator,
    /// An estimator whose command moves the robot.
    Driver,
    /// Holds the key; compares.
    Scorer,
    /// Holds the key; writes the log.
    Logger,
    /// Observes; is never waited for and may miss frames.
    Observer,
}

impl Role {
    /// Whether its answers are part of the run (and of the digest).
    #[must_use]
    pub fn answers(self) -> bool {
        matches!(self, Self::Estimator | Self::Driver)
    }

    /// Whether it receives the key to the truth.
    #[must_use]
    pub fn holds_key(self) -> bool {
        matches!(self, Self::Scorer | Self::Logger)
    }

    /// The word used in files and messages.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Estimator => "estimator",
            Self::Driver => "driver",
            Self::Scorer => "scorer",
            Self::Logger => "logger",
            Self::Observer => "observer",
        }
    }
}

impl std::fmt::Display for Role {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.word())
    }
}

/// Whether a participant is told something.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Access {
    /// It is told when it joins.
    #[default]
    Given,
    /// It has to find out.
    Hidden,
}

/// One participant of a scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Participant {
    /// Its name in roster, table and log; unique in the run.
    pub name: String,
    /// Its role.
    #[serde(default = "estimator")]
    pub role: Role,
    /// Program and arguments. In an argument, `{out}` stands for the run's folder
    /// (with a `sandbox`: a separate folder in it). `launch` appends `--run`,
    /// `--name`, `--wait`, `--launcher` and `--key-stdin`. A bare program name is
    /// searched next to the server, then on the path. Empty: started by hand.
    #[serde(default)]
    pub command: Vec<String>,
    /// Whether the run waits for it. If not, it observes only, and
    /// its answers are no part of the run.
    #[serde(default = "yes")]
    pub required: bool,
    /// Whether it receives the walls.
    #[serde(default)]
    pub map: Access,
    /// Whether it is told where the robot starts.
    #[serde(default)]
    pub initial_pose: Access,
    /// Whether the kernel confines it, if the server starts it.
    #[serde(default, skip_serializing_if = "Sandbox::is_none")]
    pub sandbox: Sandbox,
    /// Files and folders that it may read although it is confined: its model,
    /// its parameters, an interpreter's packages. In a scenario relative to the
    /// scenario's folder.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
    /// How long it is modelled to take for an answer, in simulated time.
    #[serde(default, skip_serializing_if = "ComputeTime::is_none")]
    pub compute: ComputeTime,
}

fn estimator() -> Role {
    Role::Estimator
}
fn yes() -> bool {
    true
}

impl Participant {
    /// A required participant with the usual rights, started as
    /// `<name> --run …`.
    #[must_use]
    pub fn new(name: &str, role: Role) -> Self {
        Self {
            name: name.to_owned(),
            role,
            command: vec![name.to_owned()],
            required: true,
            map: Access::Given,
            initial_pose: Access::Given,
            sandbox: Sandbox::None,
            files: Vec::new(),
            compute: ComputeTime::default(),
        }
    }

    /// Whether its answers are part of the run and of the digest.
    #[must_use]
    pub fn answers(&self) -> bool {
        self.required && self.role.answers()
    }

    /// Whether the server waits for its answers.
    #[must_use]
    pub fn is_awaited(&self) -> bool {
        self.required && self.role != Role::Observer
    }
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
            robot: RobotConfig::default(),
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

    /// Returns the configuration of the run in a world. A script's file is not read.
    #[must_use]
    pub fn config(&self, world: WorldSpec) -> RunConfig {
        RunConfig {
            scenario: self.name.clone(),
            seed: self.seed,
            ticks: self.ticks,
            dt_s: self.dt_s,
            scan_every: self.scan_every,
            start: self.start,
            robot: self.robot,
            lidar: self.lidar,
            sensors: self.sensors.clone(),
            script: self.script.clone(),
            world,
            kidnappings: self.kidnappings.clone(),
            walkers: self.walkers.clone(),
            crowd: self.crowd,
            events: self.events.clone(),
            patches: self.patches.clone(),
        }
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
        Self::check_roster(&self.participants)?;
        let drivers = self.participants.iter().filter(|p| p.role == Role::Driver).count();
        let wanted = usize::from(matches!(self.script, ScriptConfig::Driver {}));
        if drivers != wanted {
            let (problem, remedy) = if wanted == 1 {
                ("must be 1 with script kind \"driver\"", "give one participant role = \"driver\"")
            } else {
                ("must be 0 with this script", "set [script] kind = \"driver\", or another role")
            };
            return Err(FieldError::new("drivers", drivers, problem, remedy).into());
        }
        Ok(())
    }
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
    ScenarioError::Syntax(format!("{}{hint}", error.to_string().trim_end()))
}

#[cfg(test)]
mod tests;
