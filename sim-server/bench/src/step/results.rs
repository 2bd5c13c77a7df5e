//! What `bench step` comes to.

use rusty_contract::outln;
use serde::{Deserialize, Serialize};

use crate::quantiles::Spread;

/// One part of a tick.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Part {
    /// What it is.
    pub name: String,
    /// How long it takes, ns.
    pub ns: Spread,
    /// How many times longer than copying a frame.
    pub over_copy: Spread,
    /// How many times longer than a sine and a cosine.
    pub over_sine: Spread,
}

/// All parts.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StepResults {
    /// Rounds in which all parts had their turn.
    pub rounds: usize,
    /// In the order of [`super::PARTS`].
    pub parts: Vec<Part>,
    /// World digest of the first 1000 ticks of the scenario `apartment`: the
    /// same on every machine.
    pub world_digest: String,
}

impl StepResults {
    /// Prints the table.
    pub fn print(&self) {
        outln!("{:42} {:>10} {:>8} {:>8}", "", "ns", "x copy", "x sine");
        for Part { name, ns, over_copy, over_sine } in &self.parts {
            let (ns, copy, sine) = (ns.median, over_copy.median, over_sine.median);
            outln!("{name:42} {ns:>10.1} {copy:>8.2} {sine:>8.1}");
        }
        outln!("\nworld    {} after 1000 ticks of the scenario apartment", self.world_digest);
    }
}
