//! The arguments of `bench page`.

use std::path::PathBuf;

use clap::Args;

/// `bench page`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Every benchmark runs in a separate process with its usual arguments. With --write,
the measurements are kept next to the page in benchmarks/latest.json. Explanations
are read from benchmarks/notes.md, with a heading `## KEY` for each goal or
benchmark. `rusty-peers --json` (see tests/peers) writes the FILE of --peers.

Examples:
  sim-server bench page --write docs/benchmarks.md      measure all, write the page
  sim-server bench page --write docs/benchmarks.md --only scan
                                                   measure the scan only, keep the rest
  sim-server bench page --write docs/benchmarks.md --from docs/benchmarks/latest.json
                                                   render again after editing the notes")]
pub struct BenchPageArgs {
    /// Write the page to this file and its data next to it
    /// [default: print the page]
    #[arg(long, value_name = "PAGE")]
    pub write: Option<PathBuf>,
    /// Use the data of this file instead of measuring
    #[arg(long, value_name = "FILE")]
    pub from: Option<PathBuf>,
    /// Measure these only; keep the data of the others
    #[arg(long, value_delimiter = ',', value_name = "BENCH,…")]
    pub only: Vec<String>,
    /// Add the output of `rusty-peers --json` to the page
    #[arg(long, value_name = "FILE")]
    pub peers: Option<PathBuf>,
    /// Measure briefly; the numbers are examples only
    #[arg(long)]
    pub quick: bool,
}
