//! `confined`: what the server starts in place of a participant with a
//! sandbox. It confines itself and becomes the participant. Not for people.

use std::path::PathBuf;

use super::Verbed;
use crate::cli::ConfinedArgs;
use crate::error::VerbError;
use rusty_engine::confine::{Cell, become_confined};

/// Becomes the program, confined.
///
/// # Errors
/// [`VerbError::Confine`]; otherwise it does not return.
pub fn confined(args: &ConfinedArgs) -> Verbed {
    let cell = Cell {
        run: args.cell.clone(),
        program: PathBuf::from(&args.program),
        files: args.file.clone(),
        own_folder: args.own_folder.clone(),
        sandbox: args.sandbox,
    };
    match become_confined(&cell, &args.args) {
        Ok(never) => match never {},
        Err(e) => Err(VerbError::Confine(e)),
    }
}
