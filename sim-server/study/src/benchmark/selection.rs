//! `Selection`: the part of the suite that a result is about.

use rusty_contract::FieldError;
use rusty_contract::suggest::did_you_mean;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_64;

use super::entry::Entry;
use super::recorded_log::{RECORDINGS, RecordedLog};
use super::suite::{Suite, SuiteScenario};
use super::track::Track;
use crate::sweep::Seeds;

/// Most seeds of a scenario.
const MOST_SEEDS: u64 = 100_000;

/// Part of the suite, and its seeds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Selection {
    /// Names of the scenarios, in the order of the suite.
    pub scenarios: Vec<String>,
    /// Tracks that are scored.
    pub tracks: Vec<Track>,
    /// Number of seeds of each scenario.
    pub seeds: u64,
    /// Text from which the seeds are derived; without, they are those of the suite, which
    /// everyone knows.
    pub key: Option<String>,
    /// Recordings, if their scenario is in it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub recordings: Vec<RecordedLog>,
    /// Whether all scenarios and seeds of the suite are in it, for the tracks that are.
    pub whole: bool,
}

/// What was asked for on the command line.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// Names of scenarios; empty for all.
    pub only: Vec<String>,
    /// Tracks; empty for all.
    pub tracks: Vec<Track>,
    /// Number of seeds, if not the suite's.
    pub seeds: Option<u64>,
    /// Text from which the seeds are derived.
    pub key: Option<String>,
    /// Recordings.
    pub recordings: Vec<RecordedLog>,
}

impl Selection {
    /// Selects a part of the suite.
    ///
    /// # Errors
    /// [`FieldError`] names option, value and remedy.
    pub fn of(suite: &Suite, wanted: Wanted) -> Result<Self, FieldError> {
        let names = || suite.scenarios.iter().map(|s| s.name.as_str());
        if let Some(other) = wanted.only.iter().find(|only| !names().any(|name| name == *only)) {
            let hint = did_you_mean(other, names());
            let remedy = match other == RECORDINGS {
                true => "give the logs by --log FILE".to_owned(),
                false => format!("give one of {}{hint}", names().collect::<Vec<_>>().join(", ")),
            };
            return Err(FieldError::new("--only", other, "is not a scenario of it", remedy));
        }
        let is_wanted =
            |name: &&str| wanted.only.is_empty() || wanted.only.iter().any(|o| o == name);
        let tracks = Track::ALL.into_iter();
        let tracks: Vec<Track> =
            tracks.filter(|t| wanted.tracks.is_empty() || wanted.tracks.contains(t)).collect();
        let scenarios: Vec<String> = names().filter(is_wanted).map(str::to_owned).collect();
        let seeds = wanted.seeds.unwrap_or(suite.seeds);
        let whole = seeds == suite.seeds && scenarios.len() == suite.scenarios.len();
        let mut recordings = wanted.recordings;
        recordings.retain(|_| scenarios.iter().any(|name| name == RECORDINGS));
        let selection = Self { scenarios, tracks, seeds, key: wanted.key, recordings, whole };
        if selection.blocks(suite).next().is_none() {
            let words: Vec<&str> = selection.tracks.iter().map(|t| t.word()).collect();
            let has_one = |s: &&SuiteScenario| selection.tracks_of(s).next().is_some();
            let with: Vec<&str> =
                suite.scenarios.iter().filter(has_one).map(|s| s.name.as_str()).collect();
            let problem = format!("has no track {}", words.join(", "));
            let remedy = format!("give scenarios that have it: {}", with.join(", "));
            return Err(FieldError::new("--only", selection.scenarios.join(", "), problem, remedy));
        }
        Ok(selection)
    }

    /// Selects a part of the suite for these entries: without tracks, those in which one of
    /// them takes part; without entries, all.
    ///
    /// # Errors
    /// As [`of`](Self::of), or an entry takes no part.
    pub fn with(suite: &Suite, mut wanted: Wanted, added: &[Entry]) -> Result<Self, FieldError> {
        if wanted.tracks.is_empty() && !added.is_empty() {
            let takes_part = |t: &Track| added.iter().any(|e| e.is_driver == t.is_driving());
            wanted.tracks = Track::ALL.into_iter().filter(takes_part).collect();
        }
        let selection = Self::of(suite, wanted)?;
        let is_in = |e: &Entry| selection.blocks(suite).any(|(s, t)| e.takes_part(suite, s, t));
        match added.iter().find(|entry| !is_in(entry)) {
            Some(entry) => {
                let (problem, remedy) = match entry.is_driver {
                    true => ("is a driver, and no track is for one", "select the track driving"),
                    false => ("is a filter, and no track is for one", "select another track"),
                };
                Err(FieldError::new(entry.option(), &entry.name, problem, remedy))
            }
            None => Ok(selection),
        }
    }

    /// Returns the scenarios with the tracks that are scored in each.
    pub fn blocks<'s>(
        &'s self,
        suite: &'s Suite,
    ) -> impl Iterator<Item = (&'s SuiteScenario, Track)> {
        let is_in = |scenario: &&SuiteScenario| self.scenarios.contains(&scenario.name);
        let scenarios = suite.scenarios.iter().filter(is_in);
        scenarios.flat_map(|scenario| self.tracks_of(scenario).map(move |track| (scenario, track)))
    }

    /// The selected tracks that a scenario has.
    fn tracks_of<'s>(&'s self, scenario: &'s SuiteScenario) -> impl Iterator<Item = Track> {
        let tracks = self.tracks.iter().copied();
        tracks.filter(|track| !scenario.metrics(*track).is_empty())
    }

    /// Returns the seeds of the runs of a scenario; of recordings their numbers.
    ///
    /// # Errors
    /// As [`seeds`](Self::seeds).
    pub fn seeds_of(&self, scenario: &SuiteScenario) -> Result<Vec<u64>, FieldError> {
        if scenario.is_recorded() {
            return Ok((0..self.recordings.len() as u64).collect());
        }
        let seeds = self.seeds()?;
        Ok((0..seeds.count()).map(|place| seeds.at(place)).collect())
    }

    /// Returns the seeds.
    ///
    /// # Errors
    /// [`FieldError`] if the suite or a file names zero seeds, or too many.
    pub fn seeds(&self) -> Result<Seeds, FieldError> {
        if self.seeds > MOST_SEEDS {
            let remedy = format!("give at most {MOST_SEEDS}");
            return Err(FieldError::new("--seeds", self.seeds, "is too many", remedy));
        }
        let first = self.key.as_ref().map_or(0, |key| xxh3_64(key.as_bytes()) >> 1);
        let text = format!("{first}..{}", first.saturating_add(self.seeds));
        text.parse().map_err(|_| {
            FieldError::new("--seeds", self.seeds, "has no run", "give a number from 1 on")
        })
    }
}
