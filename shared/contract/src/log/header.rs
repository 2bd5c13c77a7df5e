//! What a log says about its run before the first tick.

use serde::{Deserialize, Serialize};

use crate::config::RunConfig;
use crate::scenario::{OnLoss, Participant, Scenario, ScenarioError};

/// The header of a log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogHeader {
    /// Program and version that wrote it.
    pub writer: String,
    /// Where the frames come from.
    pub source: Source,
    /// The configuration of the run. For a recording: what is known of it.
    pub config: RunConfig,
    /// Who took part, in roster order.
    pub roster: Vec<Participant>,
    /// What the scenario says about losses.
    pub on_loss: OnLoss,
}

/// Where the frames of a log come from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Source {
    /// The world made them; it can make them again.
    Simulated,
    /// A robot made them; they can only be read.
    Recorded {
        /// Format of the recording.
        format: String,
        /// Name of the file it was in, without its folder.
        file: String,
        /// What a reader should know of the conversion.
        remarks: Vec<String>,
    },
}

impl LogHeader {
    /// The roster's answering participants, in order: whose replies are part of
    /// the run.
    pub fn answering(&self) -> impl Iterator<Item = &Participant> {
        self.roster.iter().filter(|p| p.answers())
    }

    /// Checks configuration and roster: whoever reads a header builds its world,
    /// divides by its beams and makes room for its roster.
    ///
    /// # Errors
    /// [`ScenarioError`] names the first field that cannot be used.
    pub fn check(&self) -> Result<(), ScenarioError> {
        self.config.check()?;
        Scenario::check_roster(&self.roster)
    }

    /// The seed, where there is one.
    #[must_use]
    pub fn seed(&self) -> Option<u64> {
        match self.source {
            Source::Simulated => Some(self.config.seed),
            Source::Recorded { .. } => None,
        }
    }
}
