//! What `bench page` takes.

use std::path::PathBuf;

use clap::Args;

/// `bench page`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Every bench runs in a process of its own, with its usual arguments. With --write,
what they measured is kept in docs/benchmarks/latest.json beside the page, and
explanations are taken from docs/benchmarks/notes.md there (a heading `## KEY` for
each goal or bench).

Examples:
  sim-server bench page --write docs/benchmarks.md      measure all, write the page
  sim-server bench page --write docs/benchmarks.md --only scan
                                                   scan again, the rest as it was
  sim-server bench page --write docs/benchmarks.md --from docs/benchmarks/latest.json
                                                   after a change of the notes")]
pub struct BenchPageArgs {
    /// Write the page to this file, and the documents beside it [default: print
    /// the page]
    #[arg(long, value_name = "PAGE")]
    pub write: Option<PathBuf>,
    /// Measure nothing: take these documents
    #[arg(long, value_name = "FILE")]
    pub from: Option<PathBuf>,
    /// Measure these alone; the others are as in --from, or as beside the page
    #[arg(long, value_delimiter = ',', value_name = "BENCH,…")]
    pub only: Vec<String>,
    /// What `rusty-peers --json` printed (see tests/peers), to go on the page
    #[arg(long, value_name = "FILE")]
    pub peers: Option<PathBuf>,
    /// Measure for a short while: numbers that are no more than examples
    #[arg(long)]
    pub quick: bool,
}
