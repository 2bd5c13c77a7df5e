//! What `bench sweep` comes to.

use rusty_contract::outln;
use serde::{Deserialize, Serialize};

use crate::quantiles::Spread;

/// One sweep.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SweepCase {
    /// What is swept.
    pub name: String,
    /// Ticks of all runs together.
    pub ticks: u64,
    /// Rounds in which every way had its turn.
    pub rounds: usize,
    /// From plan to rows with one worker, ns.
    pub one_ns: Spread,
    /// The same with all workers, ns.
    pub all_ns: Spread,
    /// How many times longer one worker takes than all.
    pub one_over_all: Spread,
    /// How many times longer one worker takes than the bare world.
    pub one_over_bare: Spread,
    /// Hash of the run digests, the same on every machine.
    pub digests_hash: String,
}

impl SweepCase {
    /// Ticks a second that one worker makes.
    #[must_use]
    pub fn ticks_per_s(&self) -> f64 {
        self.ticks as f64 / (self.one_ns.median * 1e-9)
    }
}

/// All sweeps.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SweepResults {
    /// How many workers *all* are.
    pub jobs: usize,
    /// In the order of [`super::CASES`].
    pub cases: Vec<SweepCase>,
}

impl SweepResults {
    /// Prints the table.
    pub fn print(&self) {
        let all = format!("{} workers", self.jobs);
        outln!(
            "{:46} {:>9} {:>10} {:>8} {:>8} {:>12}",
            "",
            "1 worker",
            all,
            "1 / all",
            "1 / bare",
            "ticks/s each"
        );
        for case in &self.cases {
            outln!(
                "{:46} {:>6.1} ms {:>7.1} ms {:>8.2} {:>8.2} {:>12.0}",
                case.name,
                case.one_ns.median * 1e-6,
                case.all_ns.median * 1e-6,
                case.one_over_all.median,
                case.one_over_bare.median,
                case.ticks_per_s()
            );
        }
        outln!();
        for case in &self.cases {
            outln!("digests  {} of {}", case.digests_hash, case.name);
        }
    }
}
