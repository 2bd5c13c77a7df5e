//! Texts of scenarios.

use std::fs;
use std::path::Path;

use crate::{arg, repository};

/// Entries of a scorer and a logger.
pub const RECORDERS: &str = "[[participant]]\nname = \"score\"\nrole = \"scorer\"\n\
    command = [\"score\"]\n[[participant]]\nname = \"logger\"\nrole = \"logger\"\n\
    command = [\"logger\"]\n";

/// Writes a file, and returns its path.
pub fn write(folder: &Path, name: &str, text: impl AsRef<[u8]>) -> String {
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    arg(&path).to_owned()
}

/// A scenario of the filters, by the name of its file.
pub fn filter_scenario(name: &str) -> String {
    arg(&repository().join("clients/filters/scenarios").join(name)).to_owned()
}

/// The built-in scenario `apartment`.
pub fn apartment_scenario() -> String {
    let path = repository().join("sim-server/engine/scenarios/apartment.toml");
    fs::read_to_string(path).unwrap()
}

/// The entry of an estimator; `more` are further lines of it.
pub fn estimator(name: &str, command: &[&str], more: &str) -> String {
    format!("[[participant]]\nname = \"{name}\"\ncommand = {command:?}\n{more}\n")
}
