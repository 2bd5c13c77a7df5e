//! The verbs of the command line, one file each.

mod bench;
mod budget;
mod clean;
mod compare;
mod confined;
mod conformance;
mod control;
mod diff;
mod doctor;
mod export;
mod fork;
mod import;
mod info;
mod launch;
mod layout;
mod replay;
mod runs;
mod seal;
mod serve;
mod session;
mod sweep;
mod umbmark;
mod verify;
mod worlds;

pub use bench::{bench, bench_peer};
pub use budget::budget;
pub use clean::clean;
pub use compare::compare;
pub use confined::confined;
pub use conformance::conformance;
pub use control::control;
pub use diff::diff;
pub use doctor::doctor;
pub use export::export;
pub use fork::fork;
pub use import::import_carmen;
pub use info::info;
pub use launch::launch;
pub use layout::layout;
pub use replay::replay;
pub use runs::runs;
pub use seal::seal;
pub use serve::serve;
pub use sweep::sweep;
pub use umbmark::umbmark;
pub use verify::verify;
pub use worlds::worlds;

use std::path::Path;

use rusty_contract::{Exit, LogHeader, errln, outln};

use crate::error::VerbError;

/// What a verb comes to.
pub type Verbed = Result<Exit, VerbError>;

/// Checks that a file which the command line names is not replaced unasked.
/// Devices and pipes are written to, not replaced.
fn check_free(path: &Path, force: bool) -> Result<(), VerbError> {
    match !force && std::fs::metadata(path).is_ok_and(|found| found.is_file()) {
        true => Err(VerbError::InTheWay { path: path.display().to_string() }),
        false => Ok(()),
    }
}

/// Prints one JSON document on stdout.
fn print_json(value: &impl serde::Serialize) {
    match serde_json::to_string_pretty(value) {
        Ok(text) => outln!("{text}"),
        // Every document here is made of numbers, text and lists.
        Err(e) => errln!("sim-server: the document cannot be written: {e}"),
    }
}

/// Warns that `who` can find the run's seed by trying, and with it the truth.
fn warn_of_guessable_seed(header: &LogHeader, who: &str) {
    if let Some(seed) = header.guessable_seed() {
        errln!(
            "seed {seed} is below 2^40: {who} can find it by trying, and it gives the truth; \
             make the run with --seed random"
        );
    }
}
