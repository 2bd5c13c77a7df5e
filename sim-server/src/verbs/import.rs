//! `import`: recordings of real robots, as run logs.

use std::io::IsTerminal as _;

use rusty_contract::{Exit, errln, outln};

use super::launch::writer;
use super::{Verbed, check_free, print_json};
use crate::cli::CarmenArgs;
use rusty_logs::import::{self, ImportOptions};

/// Lines between two words of progress.
const LINES_BETWEEN_WORDS: u64 = 50_000;

/// Imports a CARMEN log.
///
/// # Errors
/// [`VerbError`](crate::error::VerbError) names line and field.
pub fn import_carmen(args: &CarmenArgs) -> Verbed {
    check_free(&args.output, args.force)?;
    let talk = std::io::stderr().is_terminal() && !args.json;
    let mut progress = |lines: u64| {
        if talk && lines.is_multiple_of(LINES_BETWEEN_WORDS) {
            errln!("  {lines} lines");
        }
    };
    let options = ImportOptions { writer: &writer(), strict: args.strict };
    let report = import::import_carmen(&args.input, &args.output, options, &mut progress)?;
    if args.json {
        print_json(&report);
    } else {
        outln!("{report}");
        outln!("log       {}", args.output.display());
        outln!("play it   sim-server replay {}", args.output.display());
    }
    Ok(Exit::Done)
}
