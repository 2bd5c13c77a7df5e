//! `bench step` on the page.

use super::PARTS;
use super::results::{Part, StepResults};
use crate::section::{Section, Table};

impl From<&StepResults> for Section {
    fn from(found: &StepResults) -> Self {
        let row = |part: &Part| {
            vec![
                part.name.clone(),
                format!("{:.1}", part.ns.median),
                format!("{:.2}", part.over_copy.median),
                format!("{:.1}", part.over_sine.median),
            ]
        };
        Self {
            title: "A tick, part by part",
            about: format!(
                "What a tick costs the server before anything is sent: medians of {} rounds, in \
                 each of which every part had its turn; the ratios are formed within a round. \
                 World digest after 1000 ticks of the scenario `apartment`, the same on every \
                 machine: `{}`.",
                found.rounds, found.world_digest
            ),
            tables: vec![Table {
                columns: vec!["part", "ns", "× copy of a frame", "× sine and cosine"],
                rows: found.parts.iter().map(row).collect(),
            }],
            findings: Vec::new(),
        }
    }
}

/// First cells of the rows that a run of the bench has.
#[must_use]
pub fn rows() -> Vec<String> {
    PARTS.iter().map(|name| (*name).to_owned()).collect()
}
