//! `completions` and `man`: what a shell and `man` know of the commands.

use std::io;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use clap::{Args, Command};
use clap_complete::Shell;
use clap_mangen::Man;
use rusty_contract::output::make_folder;
use rusty_contract::{Exit, FieldError, outln, replace};

#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Examples:
  source <(sim-server completions bash)
  sim-server completions zsh > ~/.zfunc/_sim-server
  sim-server completions fish > ~/.config/fish/completions/sim-server.fish")]
pub struct CompletionsArgs {
    /// Shell that reads them
    pub shell: Shell,
}

#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Examples:
  sim-server man ~/.local/share/man/man1
  man sim-server-launch")]
pub struct ManArgs {
    /// Folder for the pages, which is made if it is not there
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Replace pages of the same names
    #[arg(long)]
    pub force: bool,
}

/// Prints the completions of `command`.
pub fn completions(args: &CompletionsArgs, mut command: Command) -> Result<Exit> {
    let name = command.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, name, &mut script);
    outln!("{}", String::from_utf8_lossy(&script).trim_end());
    Ok(Exit::Done)
}

/// Writes a page for `command` and one for each of its verbs, or none.
pub fn man(args: &ManArgs, command: Command) -> Result<Exit> {
    let mut command = command.disable_help_subcommand(true);
    command.build();
    let mut pages = Vec::new();
    render(&command, &mut pages).context("the pages")?;
    let paths: Vec<PathBuf> = pages.iter().map(|(name, _)| args.dir.join(name)).collect();
    if let Some(there) = paths.iter().find(|path| !args.force && path.exists()) {
        let remedy = "give another folder, or --force to replace the pages";
        bail!(FieldError::new("DIR", there.display(), "is there already", remedy));
    }
    make_folder(&args.dir).with_context(|| of(&args.dir))?;
    for (path, (_, page)) in paths.iter().zip(&pages) {
        replace(path, page).with_context(|| of(path))?;
    }
    outln!("{} pages in {}", pages.len(), args.dir.display());
    Ok(Exit::Done)
}

fn of(path: &Path) -> String {
    path.display().to_string()
}

/// Adds the pages of a command and of all that it has, but for hidden ones.
fn render(command: &Command, pages: &mut Vec<(String, Vec<u8>)>) -> io::Result<()> {
    let page = Man::new(command.clone());
    let mut bytes = Vec::new();
    page.render(&mut bytes)?;
    pages.push((page.get_filename(), bytes));
    let mut verbs = command.get_subcommands().filter(|verb| !verb.is_hide_set());
    verbs.try_for_each(|verb| render(verb, pages))
}
