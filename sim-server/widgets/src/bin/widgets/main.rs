//! `widgets`: builds the module for WebAssembly, and writes the pages around it.

mod module;
mod page;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Parser;
use rusty_contract::{Exit, errln, outln, output, replace};

use crate::module::Module;
use crate::page::PAGES;

/// Write the widgets of the handbook as pages that work without a server
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// Folder for the pages; existing ones are replaced
    #[arg(long, short, value_name = "DIR", default_value = "target/widgets")]
    out: PathBuf,
}

fn main() -> Exit {
    let written = write_pages(&Arguments::parse().out);
    let exit = written.map_or_else(
        |error| {
            errln!("widgets: {error:#}");
            Exit::Failed
        },
        |()| Exit::Done,
    );
    output::finish("widgets", exit)
}

fn write_pages(out: &Path) -> Result<()> {
    // Both before the first page: no page is newer than the next.
    let modules = [Module::build(false)?, Module::build(true)?];
    fs::create_dir_all(out).with_context(|| format!("creating {} failed", out.display()))?;
    for page in &PAGES {
        let module = &modules[usize::from(page.needs_filters)];
        let path = out.join(page.file);
        write(&path, &page.html(module)?)?;
        outln!("{}: {} kB", path.display(), fs::metadata(&path)?.len() / 1000);
    }
    for module in &modules {
        outln!("{module}");
    }
    Ok(())
}

/// Writes a page as a whole: a reader never sees a part of one.
fn write(path: &Path, html: &str) -> Result<()> {
    replace(path, html.as_bytes()).with_context(|| format!("writing {} failed", path.display()))
}
