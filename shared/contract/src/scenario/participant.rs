//! Who takes part in a run, with which rights.

use serde::{Deserialize, Serialize};

use crate::data_sheet::DataSheet;
use crate::sandbox::Sandbox;
use crate::timing::ComputeTime;

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
    /// The robot that it takes part for, where there are several; without a name there
    /// is a process of it for each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
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
    /// Figures of its sensors that it is told.
    #[serde(default)]
    pub data_sheet: DataSheet,
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
            robot: None,
            command: vec![name.to_owned()],
            required: true,
            map: Access::Given,
            initial_pose: Access::Given,
            data_sheet: DataSheet::Nominal,
            sandbox: Sandbox::None,
            files: Vec::new(),
            compute: ComputeTime::default(),
        }
    }

    /// Whether it takes part for this robot of several.
    #[must_use]
    pub fn takes_part_for(&self, robot: Option<&str>) -> bool {
        self.robot.is_none() || self.robot.as_deref() == robot
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
