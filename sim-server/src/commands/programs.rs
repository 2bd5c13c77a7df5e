//! `programs`: the clients in this binary, and links under their names.

use std::ffi::OsString;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use clap::Args;
use rusty_contract::output::make_folder;
use rusty_contract::{Exit, FieldError, TextTable, outln};
use serde_json::json;

use super::arguments::Output;
use crate::names::NAMES;
use crate::programs;

/// The file name of the binary, by which links to one are recognised.
const BINARY: &str = "sim-server";

#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Started under the name of a client, the binary is that client. `sim-server ekf …` is the
same, and participants of a run need no links.

Examples:
  sim-server programs                        list the clients
  sim-server ekf --help                      the help of one of them
  sim-server programs --link ~/.cargo/bin    make `ekf` and all others commands")]
pub struct ProgramsArgs {
    /// Make a link for each client in this folder
    #[arg(long, value_name = "DIR")]
    pub link: Option<PathBuf>,
    /// Replace other files of these names
    #[arg(long, requires = "link")]
    pub force: bool,
    #[command(flatten)]
    pub output: Output,
}

pub fn run(args: &ProgramsArgs) -> Result<Exit> {
    match &args.link {
        Some(dir) => link(dir, args),
        None => list(args.output),
    }
}

fn list(output: Output) -> Result<Exit> {
    let row = |program: &'static rusty_contract::Program| json!({ "name": program.name, "purpose": program.purpose });
    output.print_with(&programs::all().map(row).collect::<Vec<_>>(), || {
        let mut table = TextTable::new("program  purpose");
        programs::all().for_each(|program| table.row(&[&program.name, &program.purpose]));
        outln!("{table}");
    });
    Ok(Exit::Done)
}

/// Every name is looked at before the first link is made.
fn link(dir: &Path, args: &ProgramsArgs) -> Result<Exit> {
    let paths: Vec<PathBuf> = NAMES.iter().map(|name| dir.join(name)).collect();
    if let Some(path) = paths.iter().find(|path| !args.force && is_other(path)) {
        let remedy = "give another folder, or --force to replace it";
        let problem = "is there already and is not a link to sim-server";
        bail!(FieldError::new("--link", path.display(), problem, remedy));
    }
    let target = target(dir)?;
    make_folder(dir).with_context(|| dir.display().to_string())?;
    for path in &paths {
        replace(path, &target).with_context(|| path.display().to_string())?;
    }
    let links = json!({ "target": target, "links": paths });
    args.output.print_with(&links, || {
        outln!("{} links to {} in {}", paths.len(), target.display(), dir.display());
    });
    Ok(Exit::Done)
}

/// Whether there is something that is not a link to a binary like this one.
fn is_other(path: &Path) -> bool {
    let is_ours = |target: PathBuf| target.file_name().is_some_and(|name| name == BINARY);
    path.symlink_metadata().is_ok() && !fs::read_link(path).is_ok_and(is_ours)
}

/// Returns the target of the links: the binary, as a relative path in its folder.
fn target(dir: &Path) -> Result<PathBuf> {
    let binary = std::env::current_exe().context("the path of this program")?;
    let is_next_to = dir.canonicalize().is_ok_and(|dir| binary.parent() == Some(&dir));
    Ok(binary.file_name().filter(|_| is_next_to).map_or(binary.clone(), PathBuf::from))
}

/// Makes one link; whatever has its name stays until the link is there.
fn replace(path: &Path, target: &Path) -> std::io::Result<()> {
    let mut hidden = OsString::from(".");
    hidden.push(path.file_name().unwrap_or_default());
    hidden.push(format!(".{}", std::process::id()));
    let new = path.with_file_name(hidden);
    symlink(target, &new)?;
    fs::rename(&new, path).inspect_err(|_| {
        let _ = fs::remove_file(&new);
    })
}
