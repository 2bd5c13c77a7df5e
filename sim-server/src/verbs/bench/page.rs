//! `bench page`.

use std::fs;
use std::path::{Path, PathBuf};

use rusty_contract::{Exit, errln, outln};

use super::super::Verbed;
use crate::cli::BenchPageArgs;
use crate::error::VerbError;
use rusty_bench::page::benches::{self, BENCHES, Bench, Source, runnable};
use rusty_bench::page::markdown::render;
use rusty_bench::page::{Documents, Notes, PageError};

/// Measures what it is asked to, and prints or writes the page.
///
/// # Errors
/// [`PageError`].
pub fn page(args: &BenchPageArgs) -> Verbed {
    let asked = asked(&args.only)?;
    let folder = folder(args.write.as_deref());
    let latest = folder.join("latest.json");
    let (mut documents, to_measure) = match &args.from {
        Some(file) => (Documents::read(file)?, asked),
        None if args.only.is_empty() => (kept(&latest)?, runnable().collect()),
        None => (kept(&latest)?, asked),
    };
    if let Some(file) = &args.peers {
        let peers = BENCHES.iter().filter(|bench| matches!(bench.source, Source::File));
        for bench in peers {
            documents.take(bench, file)?;
        }
    }
    let notes = Notes::read(&folder.join("notes.md"))?;
    if args.write.is_some() {
        fs::create_dir_all(&folder).map_err(VerbError::io(&folder))?;
    }
    for bench in to_measure {
        errln!("bench {}", bench.name);
        documents.measure(bench, args.quick)?;
        // Whatever stops the next one, this one need not be measured again.
        if args.write.is_some() {
            documents.write(&latest)?;
        }
    }
    let page = render(&documents, &notes)?;
    let Some(file) = &args.write else {
        outln!("{}", page.trim_end());
        return Ok(Exit::Done);
    };
    documents.write(&latest)?;
    fs::write(file, page).map_err(VerbError::io(file))?;
    errln!("written: {} and {}", file.display(), latest.display());
    Ok(Exit::Done)
}

/// Where documents and notes lie: beside the page, else beside where one is.
fn folder(page: Option<&Path>) -> PathBuf {
    page.and_then(Path::parent).unwrap_or(Path::new("")).join("benchmarks")
}

/// What is kept beside the page, if anything: it holds what this program cannot
/// measure itself.
fn kept(latest: &Path) -> Result<Documents, PageError> {
    if latest.exists() { Documents::read(latest) } else { Ok(Documents::default()) }
}

/// The benches of these names.
fn asked(names: &[String]) -> Result<Vec<&'static Bench>, PageError> {
    let one = |name: &String| {
        benches::bench(name).ok_or_else(|| PageError::NoSuchBench {
            name: name.clone(),
            known: runnable().map(|bench| bench.name).collect::<Vec<_>>().join(", "),
        })
    };
    names.iter().map(one).collect()
}
