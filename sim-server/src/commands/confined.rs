//! `confined`: started by the server in place of a participant with a sandbox. It
//! confines itself and becomes the participant.

use std::ffi::OsString;
use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use rusty_contract::{Exit, RunName, Sandbox};
use rusty_engine::confine::{Cell, become_confined};

#[derive(Args, Clone, Debug)]
pub struct ConfinedArgs {
    /// Run whose shared memory the program may use
    #[arg(long, value_name = "NAME")]
    pub cell: RunName,
    /// Fail with `required` unless the kernel applies all rules
    #[arg(long, value_name = "HOW")]
    pub sandbox: Sandbox,
    /// File or folder that the program may read
    #[arg(long, value_name = "PATH")]
    pub file: Vec<PathBuf>,
    /// Folder in which the program may write
    #[arg(long, value_name = "PATH")]
    pub own_folder: Option<PathBuf>,
    /// Name under which the program is started [default: PROGRAM]
    #[arg(long = "as", value_name = "NAME")]
    pub name: Option<String>,
    /// Program to execute
    pub program: OsString,
    /// Arguments of the program
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pub args: Vec<OsString>,
}

pub fn run(args: &ConfinedArgs) -> Result<Exit> {
    let cell = Cell {
        run: args.cell.clone(),
        program: PathBuf::from(&args.program),
        name: args.name.clone(),
        files: args.file.clone(),
        own_folder: args.own_folder.clone(),
        sandbox: args.sandbox,
    };
    match become_confined(&cell, &args.args) {
        Ok(never) => match never {},
        Err(e) => Err(e.into()),
    }
}
