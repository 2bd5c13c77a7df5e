//! `compare`: which of two estimators is better.

use rusty_contract::{Exit, FieldError, outln};

use super::{Verbed, print_json};
use crate::cli::CompareArgs;
use crate::error::VerbError;
use rusty_study::versus::contest::versus;
use rusty_study::versus::{Contents, Metric, VersusError, sides};

/// Compares two estimators: exit 0, whoever is better.
///
/// # Errors
/// [`VerbError`] if they cannot be compared.
pub fn compare(args: &CompareArgs) -> Verbed {
    let level = args.level;
    if !(level > 0.0 && level < 1.0) {
        let (problem, remedy) = ("is no probability between 0 and 1", "give --level 0.95");
        return Err(FieldError::new("--level", level, problem, remedy).into());
    }
    let read = |path: &std::path::PathBuf| Contents::read(path);
    let compared = || -> Result<_, VersusError> {
        let table = read(&args.table)?;
        let other = args.other.as_ref().map(read).transpose()?;
        let names = [args.a.as_deref(), args.b.as_deref()];
        let sides = sides(&table, other.as_ref(), names)?;
        let asked = !args.metrics.is_empty();
        let metrics = if asked { &args.metrics[..] } else { &Metric::USUAL[..] };
        versus(sides, metrics, asked, level)
    };
    let found = compared().map_err(VerbError::from)?;
    if args.json {
        print_json(&found);
    } else {
        outln!("{found}");
    }
    Ok(Exit::Done)
}
