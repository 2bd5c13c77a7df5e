//! `bench page`: write all benchmarks and their goals as a Markdown page.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use clap::Args;
use rusty_bench::page::render::{read_template, render};
use rusty_bench::page::{BENCHES, Bench, Documents, PageError};
use rusty_contract::output::make_folder;
use rusty_contract::{Exit, errln, outln};

#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Every benchmark runs in a separate process with its usual arguments. With --write,
the measurements are kept next to the page in benchmarks/latest.json. The text is
read from benchmarks/notes.md: {BENCH} in it becomes the tables of a benchmark,
{goals} the goals. `rusty-peers --json` (see tests/peers) writes the FILE of --peers.

Examples:
  sim-server bench page --write docs/benchmarks.md      measure all, write the page
  sim-server bench page --write docs/benchmarks.md --only scan
                                                   measure the scan only, keep the rest
  sim-server bench page --write docs/benchmarks.md --from docs/benchmarks/latest.json
                                                   render again after editing the notes")]
pub struct PageArgs {
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

pub fn run(args: &PageArgs) -> Result<Exit> {
    let asked = asked(&args.only)?;
    let folder = folder(args.write.as_deref());
    let latest = folder.join("latest.json");
    let (mut documents, to_measure) = match &args.from {
        Some(file) => (Documents::read(file)?, asked),
        None if args.only.is_empty() => (kept(&latest)?, BENCHES.iter().collect()),
        None => (kept(&latest)?, asked),
    };
    if let Some(file) = &args.peers {
        documents.take_peers(file)?;
    }
    let template = read_template(&folder.join("notes.md"))?;
    if args.write.is_some() {
        make_folder(&folder).with_context(|| folder.display().to_string())?;
    }
    for bench in to_measure {
        errln!("bench {}", bench.name);
        documents.measure(bench, args.quick)?;
        // If the next one fails, this one need not be measured again.
        if args.write.is_some() {
            documents.write(&latest)?;
        }
    }
    let page = render(&documents, &template)?;
    let Some(file) = &args.write else {
        outln!("{}", page.trim_end());
        return Ok(Exit::Done);
    };
    documents.write(&latest)?;
    fs::write(file, page).with_context(|| file.display().to_string())?;
    errln!("written: {} and {}", file.display(), latest.display());
    Ok(Exit::Done)
}

/// Returns the folder of documents and notes, which is next to the page.
fn folder(page: Option<&Path>) -> PathBuf {
    page.and_then(Path::parent).unwrap_or(Path::new("")).join("benchmarks")
}

/// Returns the documents next to the page, if any: this program cannot measure all
/// of them.
fn kept(latest: &Path) -> Result<Documents, PageError> {
    if latest.exists() { Documents::read(latest) } else { Ok(Documents::default()) }
}

fn asked(names: &[String]) -> Result<Vec<&'static Bench>, PageError> {
    let one = |name: &String| {
        BENCHES.iter().find(|bench| bench.name == *name).ok_or_else(|| PageError::NoSuchBench {
            name: name.clone(),
            known: BENCHES.iter().map(|bench| bench.name).collect::<Vec<_>>().join(", "),
        })
    };
    names.iter().map(one).collect()
}
