//! `Block`: the runs of an entry in a scenario.

use rusty_contract::Sandbox;
use rusty_contract::scenario::Access;

use super::entry::Entry;
use super::error::BenchmarkError;
use super::selection::Selection;
use super::suite::{Suite, SuiteScenario};
use crate::sweep::{Plan, Request};

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

impl Block<'_> {
    /// Returns its runs.
    ///
    /// # Errors
    /// [`BenchmarkError`] names field, value and remedy.
    pub fn plan(&self, selection: &Selection, sandbox: Sandbox) -> Result<Plan, BenchmarkError> {
        let request = Request {
            scenario: self.scenario.base.clone(),
            seeds: selection.seeds()?,
            axes: self.scenario.axes()?,
            ticks: None,
            clients: true,
            add: Vec::new(),
        };
        let roster = self.entry.roster(self.scenario, self.map, sandbox);
        Ok(Plan::with_roster(request, &roster)?)
    }
}
