//! `Block`: the runs of an entry in a scenario.

use rusty_contract::scenario::Access;
use rusty_contract::{Participant, Sandbox};

use super::entry::Entry;
use super::error::BenchmarkError;
use super::selection::Selection;
use super::suite::{Suite, SuiteScenario};
use super::track::map_word;
use crate::sweep::{Plan, Request, Seeds};

/// The runs of an entry in a scenario, with or without the map.
pub struct Block<'s> {
    /// The scenario.
    pub scenario: &'s SuiteScenario,
    /// Whether the entry receives the map.
    pub map: Access,
    /// The entry.
    pub entry: &'s Entry,
}

/// Returns the blocks of these entries: of a baseline those in its tracks, of others those of
/// all drivers or estimators.
/// Those added come first, so that trouble with them shows early.
#[must_use]
pub fn blocks<'s>(
    suite: &'s Suite,
    selection: &'s Selection,
    entries: &'s [Entry],
) -> Vec<Block<'s>> {
    let mut all: Vec<Block<'s>> = Vec::new();
    for (scenario, track) in selection.blocks(suite) {
        for entry in entries.iter().filter(|entry| entry.takes_part(suite, scenario, track)) {
            let map = track.map();
            let is_there = all.iter().any(|block| {
                let name = &block.scenario.name;
                *name == scenario.name && block.map == map && block.entry.name == entry.name
            });
            if !is_there {
                all.push(Block { scenario, map, entry });
            }
        }
    }
    all.sort_by_key(|block| block.entry.is_baseline);
    all
}

/// Returns the name of a run in files: `number` counts the seeds from 0.
#[must_use]
pub fn run_name(scenario: &SuiteScenario, map: Access, number: u64) -> String {
    format!("{}-{}-{number}", scenario.name, map_word(map))
}

impl Block<'_> {
    /// Returns its runs: as one plan, or in a plan each if the command differs by run.
    ///
    /// # Errors
    /// [`BenchmarkError`] names field, value and remedy.
    pub fn plans(
        &self,
        selection: &Selection,
        sandbox: Sandbox,
    ) -> Result<Vec<Plan>, BenchmarkError> {
        let roster = |entry: &Entry| entry.roster(self.scenario, self.map, sandbox);
        let seeds = selection.seeds()?;
        if !self.entry.differs_by_run() {
            return Ok(vec![self.scenario.plan(seeds, &roster(self.entry))?]);
        }
        let plan = |number| {
            let entry = self.entry.of_run(&run_name(self.scenario, self.map, number));
            self.scenario.plan(Seeds::one(seeds.at(number)), &roster(&entry))
        };
        (0..seeds.count()).map(plan).collect()
    }
}

impl SuiteScenario {
    /// Returns the runs with these seeds and participants.
    ///
    /// # Errors
    /// [`BenchmarkError`] names field, value and remedy.
    pub(super) fn plan(
        &self,
        seeds: Seeds,
        roster: &[Participant],
    ) -> Result<Plan, BenchmarkError> {
        let request = Request {
            scenario: self.base.clone(),
            seeds,
            axes: self.axes()?,
            ticks: None,
            clients: true,
            add: Vec::new(),
        };
        Ok(Plan::with_roster(request, roster)?)
    }
}
