//! What a log says about its run before the first tick.

use rusty_geometry::{SE2, WorldSpec};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value};

use super::Finding;
use crate::config::{Kidnapping, RunConfig};
use crate::data_sheet::{DataSheet, LidarSheet, SensorSheets};
use crate::json::{json, json_tree, through_tree};
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
    #[serde(deserialize_with = "roster_of_log")]
    pub roster: Vec<Participant>,
    /// What the scenario says about losses.
    pub on_loss: OnLoss,
}

/// Where the frames of a log come from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Source {
    /// The world made them; it can make them again.
    Simulated,
    /// The world made them, and something of it changed in the middle.
    Forked {
        /// The first tick for which the header's configuration holds.
        at_tick: u64,
        /// The configuration up to there: what everyone was told of.
        #[serde(deserialize_with = "through_tree")]
        before: Box<RunConfig>,
    },
    /// A robot made them; they can only be read.
    Recorded {
        /// Format of the recording.
        format: String,
        /// Name of the file it was in, without its folder.
        file: String,
        /// What a reader should know of the conversion.
        remarks: Vec<String>,
        /// Defects of the recording.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        findings: Vec<Finding>,
    },
    /// Sealed: frames and replies of another log, without its truth. See
    /// [`crate::blind`].
    Blind {
        /// What it was: a simulation or a recording.
        of: String,
        /// [Observable digest](crate::digest::ObservableDigest) of all its
        /// frames, 32 hexadecimal digits.
        observable_digest: String,
        /// How many frames those are.
        ticks: u64,
        /// Whether `start` in the configuration is where the robot started.
        start_known: bool,
        /// Whether `world` in the configuration is where it drove.
        world_known: bool,
        /// Whether the figures of the sensors in the configuration are the true ones.
        #[serde(default = "yes")]
        figures_known: bool,
    },
}

fn yes() -> bool {
    true
}

/// [`Source::Blind`]: it was a recording.
pub(crate) const RECORDING: &str = "recording";

/// Reads a roster: before there were data sheets, everyone was told the true figures.
fn roster_of_log<'de, D: Deserializer<'de>>(input: D) -> Result<Vec<Participant>, D::Error> {
    let mut entries = Vec::<Map<String, Value>>::deserialize(input)?;
    let of_log = |mut entry: Map<String, Value>| {
        entry.entry("data_sheet").or_insert_with(|| DataSheet::Given.word().into());
        Participant::deserialize(&Value::Object(entry)).map_err(D::Error::custom)
    };
    entries.drain(..).map(of_log).collect()
}

json!(LogHeader);
json_tree!(LogHeader);

impl LogHeader {
    /// Returns the header of a simulated run of a scenario in a world.
    #[must_use]
    pub fn simulated(writer: &str, scenario: &Scenario, world: WorldSpec) -> Self {
        Self {
            writer: writer.to_owned(),
            source: Source::Simulated,
            config: scenario.config(world),
            roster: scenario.roster_of(0),
            on_loss: scenario.on_loss,
        }
    }

    /// The roster's answering participants, in order: whose replies are part of
    /// the run.
    pub fn answering(&self) -> impl Iterator<Item = &Participant> {
        self.roster.iter().filter(|p| p.answers())
    }

    /// Checks configuration and roster: a reader of a header builds its world,
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
            Source::Simulated | Source::Forked { .. } => Some(self.config.seed),
            Source::Recorded { .. } | Source::Blind { .. } => None,
        }
    }

    /// The smallest seed of the run, if it is small enough to be found by trying:
    /// noise is a function of seed and place, so one scan tests a seed.
    #[must_use]
    pub fn guessable_seed(&self) -> Option<u64> {
        let before = match &self.source {
            Source::Forked { before, .. } => Some(before.seed),
            _ => None,
        };
        self.seed().into_iter().chain(before).min().filter(|seed| *seed < 1 << 40)
    }

    /// What participants are told of before the first tick: where the world
    /// changes in the middle of the run, as it was at the start.
    #[must_use]
    pub fn told(&self) -> &RunConfig {
        match &self.source {
            Source::Forked { before, .. } => before,
            _ => &self.config,
        }
    }

    /// Where the robot is carried away in this run: of a fork what held at each
    /// tick.
    pub fn kidnappings(&self) -> impl Iterator<Item = &Kidnapping> {
        let (at_tick, before) = match &self.source {
            Source::Forked { at_tick, before } => (*at_tick, &before.kidnappings[..]),
            _ => (0, &[][..]),
        };
        let before = before.iter().filter(move |k| k.tick < at_tick);
        before.chain(self.config.kidnappings.iter().filter(move |k| k.tick >= at_tick))
    }

    /// Defects of the recording; empty for everything else.
    #[must_use]
    pub fn findings(&self) -> &[Finding] {
        match &self.source {
            Source::Recorded { findings, .. } => findings,
            _ => &[],
        }
    }

    /// Whether a robot made the frames.
    #[must_use]
    pub fn is_recording(&self) -> bool {
        match &self.source {
            Source::Recorded { .. } => true,
            Source::Blind { of, .. } => of == RECORDING,
            Source::Simulated | Source::Forked { .. } => false,
        }
    }

    /// Whether the truth was taken out of this log.
    #[must_use]
    pub fn is_blind(&self) -> bool {
        matches!(self.source, Source::Blind { .. })
    }

    /// Where the robot starts, if this log may say so.
    #[must_use]
    pub fn known_start(&self) -> Option<SE2> {
        let hidden = matches!(self.source, Source::Blind { start_known: false, .. });
        (!hidden).then_some(self.config.start)
    }

    /// The true pose before the first tick: known of a simulation, whose robot
    /// stands there.
    #[must_use]
    pub fn true_start(&self) -> Option<SE2> {
        let simulated = matches!(self.source, Source::Simulated | Source::Forked { .. });
        simulated.then_some(self.config.start)
    }

    /// The walls, if this log may say so. A recording without any has none to tell: its
    /// bounds are those of the true path.
    #[must_use]
    pub fn known_world(&self) -> Option<&WorldSpec> {
        let hidden = matches!(self.source, Source::Blind { world_known: false, .. });
        let world = &self.config.world;
        let is_empty = world.walls.is_empty() && world.landmarks.is_empty();
        (!(hidden || self.is_recording() && is_empty)).then_some(world)
    }

    /// Returns which figures of its sensors a participant is told. The holder of a key
    /// reads them in its brief.
    #[must_use]
    pub fn data_sheet_of(&self, participant: &Participant) -> DataSheet {
        let unknown = matches!(self.source, Source::Blind { figures_known: false, .. });
        match participant.data_sheet {
            _ if participant.role.holds_key() => DataSheet::Hidden,
            DataSheet::Given if unknown => DataSheet::Hidden,
            sheet => sheet,
        }
    }

    /// Returns what a participant with this data sheet is told of LiDAR and small sensors
    /// at the start.
    #[must_use]
    pub fn sheets(&self, sheet: DataSheet) -> (LidarSheet, SensorSheets) {
        // The header of a recording has the figures of its data sheets.
        let sheet = match sheet {
            DataSheet::Nominal if self.is_recording() => DataSheet::Given,
            sheet => sheet,
        };
        let told = self.told();
        (LidarSheet::new(&told.lidar, sheet), SensorSheets::new(&told.sensors, sheet))
    }

    /// Seed, or why there is none, in words.
    #[must_use]
    pub fn seed_in_words(&self) -> String {
        let seed = self.config.seed;
        match &self.source {
            Source::Simulated => format!("seed {seed}"),
            Source::Forked { at_tick, before } if before.seed == seed => {
                format!("seed {seed}, forked at tick {at_tick}")
            }
            Source::Forked { at_tick, before } => {
                format!("seed {}, and {seed} from tick {at_tick} on", before.seed)
            }
            Source::Recorded { .. } => "recorded by a robot (no seed)".to_owned(),
            Source::Blind { .. } => "blind (no seed, no truth)".to_owned(),
        }
    }
}
