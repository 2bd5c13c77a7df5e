//! Which benches are on the page.

use serde::de::DeserializeOwned;
use serde_json::Value;

use super::Section;
use crate::bench::scan::{self, results::ScanResults};
use crate::bench::step::{self, results::StepResults};

/// A bench on the page.
#[derive(Clone, Copy, Debug)]
pub struct Bench {
    /// The word after `sim-server bench`.
    pub name: &'static str,
    /// Further arguments of a short run, whose numbers are no more than examples.
    pub quick: &'static [&'static str],
    /// Its results as a section; fails on results of another form.
    pub section: fn(&Value) -> Result<Section, serde_json::Error>,
    /// First cells of all rows that a run has, as of this version.
    pub rows: fn() -> Vec<String>,
}

/// The benches in the order of the page.
pub const BENCHES: [Bench; 2] = [
    Bench {
        name: "scan",
        quick: &["--seconds", "0.02"],
        section: section::<ScanResults>,
        rows: scan::section::rows,
    },
    Bench {
        name: "step",
        quick: &["--seconds", "0.2"],
        section: section::<StepResults>,
        rows: step::section::rows,
    },
];

/// The bench of this name.
#[must_use]
pub fn bench(name: &str) -> Option<&'static Bench> {
    BENCHES.iter().find(|bench| bench.name == name)
}

/// The section that results of the form `R` make.
fn section<R>(results: &Value) -> Result<Section, serde_json::Error>
where
    R: DeserializeOwned,
    for<'a> Section: From<&'a R>,
{
    R::deserialize(results).map(|results| Section::from(&results))
}
