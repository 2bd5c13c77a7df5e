//! `bench page`: the page of all benchmarks, made from their reports.
//!
//! * [`documents`]: the reports, kept in a file next to the page, so that the page
//!   can be made again without measuring;
//! * [`goals`]: what the figures should reach;
//! * [`render`]: the page, from reports and a template.
//!
//! The prose is in the template, a file next to the page. `{BENCH}` in it is
//! replaced by the tables of a benchmark, `{BENCH.FACT}` by one of its facts, and
//! `{goals}` by all goals with what was found.

pub mod documents;
mod error;
pub mod goals;
pub mod render;

pub use documents::Documents;
pub use error::PageError;

use crate::{idle, latency, log, scan, start, step, sweep};

/// The name of the report that `rusty-peers` writes, a program next to the workspace.
pub const PEERS: &str = "peers";

/// A benchmark of this program on the page.
#[derive(Clone, Copy, Debug)]
pub struct Bench {
    /// The word after `sim-server bench`.
    pub name: &'static str,
    /// Its arguments.
    args: &'static [&'static str],
    /// Further ones for a short run, whose numbers are examples only.
    quick: &'static [&'static str],
    /// Names of all rows of its first table as of this version.
    rows: fn() -> Vec<String>,
}

/// The benchmarks in the order in which they are measured.
pub const BENCHES: [Bench; 7] = [
    bench("latency", &["--mix"], &["--ticks", "500", "--repeat", "1"], latency::rows),
    bench("scan", &[], &["--seconds", "0.02"], scan::rows),
    bench("step", &[], &["--seconds", "0.2"], step::rows),
    bench("sweep", &[], &["--seconds", "0.2"], sweep::rows),
    bench("log", &[], &["--ticks", "1000", "--repeat", "1"], log::rows),
    bench("idle", &[], &["--seconds", "0.5"], idle::rows),
    bench("start", &[], &["--repeat", "2"], start::rows),
];

const fn bench(
    name: &'static str,
    args: &'static [&'static str],
    quick: &'static [&'static str],
    rows: fn() -> Vec<String>,
) -> Bench {
    Bench { name, args, quick, rows }
}
