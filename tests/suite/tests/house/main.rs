//! Rules of the repository, read from its sources and pages.

mod arrows;
mod first_filter;
mod handbook;
mod house_rules;
mod licences;
mod locks;
mod streams;

use std::fs;
use std::path::Path;

fn read(path: impl AsRef<Path>) -> String {
    let path = rusty_tests::repository().join(path);
    fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn table(path: &str) -> toml::Table {
    toml::from_str(&read(path)).unwrap()
}
