//! `Suite`: the scenarios of the benchmark, and the baselines.

use std::fmt;

use rusty_contract::scenario::Access;
use rusty_contract::{FieldError, RunConfig, TextTable};
use rusty_engine::scenario_file;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::Xxh3;

use super::error::BenchmarkError;
use super::recorded_log::{RECORDINGS, RecordedLog};
use super::track::Track;
use crate::sweep::{Axis, SweepError};
use crate::versus::Metric;

/// The suite of this program.
const TEXT: &str = include_str!("suite.toml");

/// The scenarios of the benchmark, and the baselines.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Suite {
    /// Its version; results of two versions are not comparable.
    pub version: u32,
    /// Number of seeds of each scenario.
    pub seeds: u64,
    /// Those that every entry is compared with.
    #[serde(rename = "baseline")]
    pub baselines: Vec<Baseline>,
    /// The scenarios, in order.
    #[serde(rename = "scenario")]
    pub scenarios: Vec<SuiteScenario>,
}

/// An entry that every other is compared with.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baseline {
    /// Its name.
    pub name: String,
    /// Program and arguments.
    pub command: Vec<String>,
    /// Where it takes part.
    pub tracks: Vec<Track>,
    /// Whether it takes no part where the start is hidden.
    #[serde(default)]
    pub needs_start: bool,
}

/// A scenario: a built-in one with changes.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SuiteScenario {
    /// Its name.
    pub name: String,
    /// A line about it.
    pub about: String,
    /// Name of the built-in scenario.
    pub base: String,
    /// Changes to it, as of `launch --set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Program and arguments of the driver; without, the scenario's script drives.
    #[serde(default)]
    pub driver: Vec<String>,
    /// Whether estimators are told where the robot starts.
    #[serde(default)]
    pub start: Access,
    /// Metrics of the track, the first of which decides; none where it is no track here.
    #[serde(default)]
    pub localisation: Vec<Metric>,
    /// The same.
    #[serde(default)]
    pub odometry: Vec<Metric>,
    /// The same.
    #[serde(default)]
    pub slam: Vec<Metric>,
    /// The same. A scenario with this track has no other.
    #[serde(default)]
    pub driving: Vec<Metric>,
    /// Goals of the drivers, m, world frame, to be reached in order.
    #[serde(default)]
    pub goals: Vec<[f64; 2]>,
}

impl Suite {
    /// Returns the suite of this program.
    ///
    /// # Errors
    /// [`BenchmarkError::Suite`] if it cannot be read: no suite that passed the tests.
    pub fn built_in() -> Result<Self, BenchmarkError> {
        toml::from_str(TEXT).map_err(BenchmarkError::Suite)
    }

    /// Returns the suite with recordings as its last scenario, if there are any.
    #[must_use]
    pub fn with(mut self, recordings: &[RecordedLog]) -> Self {
        self.scenarios.retain(|scenario| !scenario.is_recorded());
        self.scenarios.extend((!recordings.is_empty()).then(SuiteScenario::of_recordings));
        self
    }

    /// Returns the digest of its text, and of the configuration of every scenario: world,
    /// robot, sensors and script.
    ///
    /// # Errors
    /// [`BenchmarkError`] if a scenario cannot be set up.
    pub fn digest(&self) -> Result<String, BenchmarkError> {
        let mut hash = Xxh3::new();
        hash.update(TEXT.as_bytes());
        for scenario in self.scenarios.iter().filter(|scenario| !scenario.is_recorded()) {
            let config = serde_json::to_vec(&scenario.config()?);
            hash.update(&config.map_err(BenchmarkError::Json)?);
        }
        Ok(format!("{:032x}", hash.digest128()))
    }

    /// Returns the baselines of a track in a scenario; the first is the reference.
    pub fn baselines_of(
        &self,
        scenario: &SuiteScenario,
        track: Track,
    ) -> impl Iterator<Item = &Baseline> {
        let start = scenario.start;
        self.baselines.iter().filter(move |baseline| {
            let knows_enough = start == Access::Given || !baseline.needs_start;
            baseline.tracks.contains(&track) && knows_enough
        })
    }
}

impl SuiteScenario {
    /// The scenario of all recordings.
    fn of_recordings() -> Self {
        Self {
            name: RECORDINGS.to_owned(),
            about: "recordings of robots, each a run".to_owned(),
            base: String::new(),
            set: Vec::new(),
            driver: Vec::new(),
            start: Access::Given,
            localisation: Vec::new(),
            odometry: vec![Metric::RpeMetre, Metric::AteSe2],
            slam: vec![Metric::AteSe2, Metric::Ate],
            driving: Vec::new(),
            goals: Vec::new(),
        }
    }

    /// Whether its runs are replays of logs.
    pub(super) fn is_recorded(&self) -> bool {
        self.name == RECORDINGS
    }

    /// Returns the metrics of a track; the first decides.
    #[must_use]
    pub fn metrics(&self, track: Track) -> &[Metric] {
        match track {
            Track::Localisation => &self.localisation,
            Track::Odometry => &self.odometry,
            Track::Slam => &self.slam,
            Track::Driving => &self.driving,
        }
    }

    /// Returns the metrics of all tracks with this map, each once.
    #[must_use]
    pub fn metrics_with(&self, map: Access) -> Vec<Metric> {
        let tracks = Track::ALL.iter().filter(|track| track.map() == map);
        let mut all: Vec<Metric> = tracks.flat_map(|t| self.metrics(*t)).copied().collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Returns the goals as words of a command line, each after `option`.
    pub fn goals_after<'s>(&'s self, option: &'s str) -> impl Iterator<Item = String> + 's {
        let words = move |[x_m, y_m]: &[f64; 2]| [option.to_owned(), format!("{x_m},{y_m}")];
        self.goals.iter().flat_map(words)
    }

    /// Returns the changes as fields with a value each.
    ///
    /// # Errors
    /// [`FieldError`] names the text.
    pub fn axes(&self) -> Result<Vec<Axis>, FieldError> {
        self.set.iter().map(|text| Axis::parse("set", text)).collect()
    }

    /// Returns the configuration of its runs, but for the seed.
    fn config(&self) -> Result<RunConfig, SweepError> {
        let loaded = scenario_file::load_unchecked(&self.base, &self.set)?;
        Ok(loaded.config()?)
    }
}

impl fmt::Display for Suite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "suite {}, {} seeds of each scenario\n", self.version, self.seeds)?;
        let mut table = TextTable::new("scenario  track  metrics  baselines  about");
        for scenario in &self.scenarios {
            let tracks = Track::ALL.into_iter().filter(|t| !scenario.metrics(*t).is_empty());
            for track in tracks {
                let metrics: Vec<&str> =
                    scenario.metrics(track).iter().map(|m| m.words()).collect();
                let baselines: Vec<&str> =
                    self.baselines_of(scenario, track).map(|b| b.name.as_str()).collect();
                let (metrics, baselines) = (metrics.join(", "), baselines.join(", "));
                table.row(&[&scenario.name, &track.word(), &metrics, &baselines, &scenario.about]);
            }
        }
        write!(f, "{table}")
    }
}
