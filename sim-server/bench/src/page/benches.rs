//! Which benches are on the page.

use serde::de::DeserializeOwned;
use serde_json::Value;

use super::Section;
use super::peers::{self, PeersResults};
use crate::idle::{self, Results as IdleResults};
use crate::latency::{self, Results as LatencyResults};
use crate::log::{self, Results as LogResults};
use crate::scan::{self, results::ScanResults};
use crate::start::{self, Results as StartResults};
use crate::step::{self, results::StepResults};
use crate::sweep::{self, results::SweepResults};

/// A bench on the page.
#[derive(Clone, Copy, Debug)]
pub struct Bench {
    /// The word after `sim-server bench`, and its name among the documents.
    pub name: &'static str,
    /// Where its document comes from.
    pub source: Source,
    /// Its results as a section; fails on results of another form.
    pub section: fn(&Value) -> Result<Section, serde_json::Error>,
    /// First cells of all rows that a run has, as of this version.
    pub rows: fn() -> Vec<String>,
}

/// Where a document comes from.
#[derive(Clone, Copy, Debug)]
pub enum Source {
    /// A bench of this program.
    Run {
        /// Its arguments.
        args: &'static [&'static str],
        /// Further ones for a short run, whose numbers are no more than examples.
        quick: &'static [&'static str],
    },
    /// A file that another program wrote, given with `--peers`; without one the
    /// section is left out.
    File,
}

/// The benches in the order of the page.
pub const BENCHES: [Bench; 8] = [
    Bench {
        name: "latency",
        source: Source::Run { args: &["--mix"], quick: &["--ticks", "500", "--repeat", "1"] },
        section: section::<LatencyResults>,
        rows: latency::section::rows,
    },
    Bench {
        name: "peers",
        source: Source::File,
        section: section::<PeersResults>,
        rows: peers::rows,
    },
    Bench {
        name: "scan",
        source: Source::Run { args: &[], quick: &["--seconds", "0.02"] },
        section: section::<ScanResults>,
        rows: scan::section::rows,
    },
    Bench {
        name: "step",
        source: Source::Run { args: &[], quick: &["--seconds", "0.2"] },
        section: section::<StepResults>,
        rows: step::section::rows,
    },
    Bench {
        name: "sweep",
        source: Source::Run { args: &[], quick: &["--seconds", "0.2"] },
        section: section::<SweepResults>,
        rows: sweep::section::rows,
    },
    Bench {
        name: "log",
        source: Source::Run { args: &[], quick: &["--ticks", "1000", "--repeat", "1"] },
        section: section::<LogResults>,
        rows: log::section::rows,
    },
    Bench {
        name: "idle",
        source: Source::Run { args: &[], quick: &["--seconds", "0.5"] },
        section: section::<IdleResults>,
        rows: idle::section::rows,
    },
    Bench {
        name: "start",
        source: Source::Run { args: &[], quick: &["--repeat", "2"] },
        section: section::<StartResults>,
        rows: start::section::rows,
    },
];

/// The bench of this program with this name.
#[must_use]
pub fn bench(name: &str) -> Option<&'static Bench> {
    runnable().find(|bench| bench.name == name)
}

/// The benches of this program.
pub fn runnable() -> impl Iterator<Item = &'static Bench> {
    BENCHES.iter().filter(|bench| matches!(bench.source, Source::Run { .. }))
}

/// The section that results of the form `R` make.
fn section<R>(results: &Value) -> Result<Section, serde_json::Error>
where
    R: DeserializeOwned,
    for<'a> Section: From<&'a R>,
{
    R::deserialize(results).map(|results| Section::from(&results))
}
